#include "pipeline/assets/mesh_appearance.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace wry::pipeline {

namespace {

const geometry::VertexAttribute* find_attribute(const geometry::SurfaceMesh& mesh, const std::string& name,
                                                int components) {
  for (const geometry::VertexAttribute& attribute : mesh.attributes) {
    if (attribute.name == name && attribute.components == components)
      return &attribute;
  }
  return nullptr;
}

float to_linear(double value, ColourCurve curve) {
  const double v = std::clamp(value, 0.0, 1.0);
  if (curve == ColourCurve::linear)
    return static_cast<float>(v);
  return static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
}

/// For each corner of the triangle the raw vertex that became it; false when the raw triangle is another one.
bool match(const Triangles& triangles, Eigen::Index t, const std::array<std::int32_t, 3>& raw,
           const std::vector<std::int32_t>& map, std::array<std::int32_t, 3>& corners) {
  for (int c = 0; c < 3; ++c) {
    const auto found = std::find_if(raw.begin(), raw.end(), [&](std::int32_t vertex) {
      return map[static_cast<std::size_t>(vertex)] == triangles(t, c);
    });
    if (found == raw.end())
      return false;
    corners[static_cast<std::size_t>(c)] = *found;
  }
  return true;
}

} // namespace

std::optional<render::MeshAppearance> make_appearance(const RawMesh& raw, const Triangles& triangles,
                                                      const std::vector<std::int32_t>& map, ColourCurve curve) {
  const geometry::VertexAttribute* uv = find_attribute(raw.mesh, "uv", 2);
  const geometry::VertexAttribute* colour = find_attribute(raw.mesh, "colour", 3);
  const bool has_materials =
      !raw.materials.empty() && raw.material_of_triangle.size() == static_cast<std::size_t>(raw.mesh.triangles.rows());
  if (!has_materials && colour == nullptr)
    return std::nullopt;
  render::MeshAppearance made;
  made.materials = raw.materials;
  made.textures = raw.textures;
  if (!has_materials) {
    made.materials.assign(1, {});
    made.materials.front().base_colour = Eigen::Vector3f::Ones();
  }
  // Paint counts alone: plain materials beside it are usually a program's default grey.
  for (render::ArtistMaterial& material : made.materials) {
    if (colour != nullptr && material.texture < 0)
      material.base_colour = Eigen::Vector3f::Ones();
  }
  Eigen::Index t = 0;
  for (Eigen::Index r = 0; r < raw.mesh.triangles.rows() && t < triangles.rows(); ++r) {
    const std::array<std::int32_t, 3> raw_triangle = {raw.mesh.triangles(r, 0), raw.mesh.triangles(r, 1),
                                                      raw.mesh.triangles(r, 2)};
    std::array<std::int32_t, 3> corners{};
    if (!match(triangles, t, raw_triangle, map, corners))
      continue;
    const std::int32_t material = has_materials ? raw.material_of_triangle[static_cast<std::size_t>(r)] : 0;
    made.material_of_triangle.push_back(std::clamp(material, 0, static_cast<std::int32_t>(made.materials.size()) - 1));
    for (const std::int32_t corner : corners) {
      const auto row = static_cast<std::size_t>(corner);
      if (uv != nullptr) // the file's v counts from below
        made.corner_uv.push_back(
            {static_cast<float>(uv->values[2 * row]), static_cast<float>(1.0 - uv->values[2 * row + 1])});
      if (colour != nullptr)
        made.corner_colour.emplace_back(to_linear(colour->values[3 * row], curve),
                                        to_linear(colour->values[3 * row + 1], curve),
                                        to_linear(colour->values[3 * row + 2], curve));
    }
    ++t;
  }
  if (t != triangles.rows())
    return std::nullopt;
  return made;
}

} // namespace wry::pipeline
