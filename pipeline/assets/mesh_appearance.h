#pragma once

#include <optional>
#include <vector>

#include "pipeline/assets/import_protocol.h"
#include "render/mesh_appearance.h"

namespace wry::pipeline {

/// How colours of vertices are stored in a file.
enum class ColourCurve { srgb, linear };

/// The materials of a raw mesh for the mesh that welding and orienting made of it: `map` leads from raw vertices to its
/// own, its triangles are a part of the raw ones in the same order, perhaps turned over. Absent when the file says
/// nothing about looks, or the meshes do not belong together.
std::optional<render::MeshAppearance> make_appearance(const RawMesh& raw, const Triangles& triangles,
                                                      const std::vector<std::int32_t>& map, ColourCurve curve);

} // namespace wry::pipeline
