#include "sim/scene/rest_points.h"

#include <fmt/format.h>

namespace wry::scene {

RestPoints rest_points(const geometry::TetMesh& mesh) {
  return {mesh.vertices, mesh.body_coordinates, mesh.attributes};
}

std::vector<std::string> component_names(std::span<const geometry::VertexAttribute> attributes) {
  std::vector<std::string> names;
  for (const geometry::VertexAttribute& attribute : attributes) {
    for (int i = 0; i < attribute.components; ++i) {
      if (attribute.components == 1)
        names.push_back(attribute.name);
      else if (attribute.components <= 4)
        names.push_back(fmt::format("{}_{}", attribute.name, "xyzw"[i]));
      else
        names.push_back(fmt::format("{}_{}", attribute.name, i));
    }
  }
  return names;
}

} // namespace wry::scene
