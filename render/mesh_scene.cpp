#include "render/mesh_scene.h"

namespace wry::render {

MeshScene make_mesh_scene(const geometry::SurfaceMesh& mesh, const std::string& name, const std::string& look) {
  MeshScene made;
  SceneBody body;
  body.name = name;
  body.look = look;
  body.simulated = false;
  body.rest_positions = mesh.vertices;
  body.triangles = mesh.triangles;
  made.scene.bodies.push_back(std::move(body));
  FrameBody on_frame;
  on_frame.name = name;
  for (const geometry::VertexAttribute& attribute : mesh.attributes)
    on_frame.channels.push_back(
        {attribute.name, ChannelOn::vertex, attribute.components, ChannelStorage::float32, attribute.values});
  made.frame.number = 1;
  made.frame.bodies.push_back(std::move(on_frame));
  made.bounds.include(mesh.vertices);
  return made;
}

} // namespace wry::render
