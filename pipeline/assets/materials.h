#pragma once

#include "pipeline/assets/import_protocol.h"
#include "pipeline/assets/scene_decoder.h"

struct aiScene;

namespace wry::pipeline {

/// Base colours, gloss and pictures of a scene's materials, in the scene's order. Pictures are those in the file and
/// those beside it that were read with it (PNG, JPEG, Targa); one that is missing or damaged becomes a note.
void gather_materials(const aiScene& scene, const MeshFile& file, RawMesh& raw);

/// Decodes a PNG, a JPEG or a Targa from memory. Errors: bad_input for anything else, damaged, or above 8192 pixels a
/// side.
Result<render::Image> decode_picture(const std::string& bytes);

} // namespace wry::pipeline
