#pragma once

#include <filesystem>
#include <string>

#include "pipeline/plan/mesh_body.h"

namespace wry::pipeline {

/// mesh_body(), done once for all processes that name the same folder: import, level set and tets of equal bodies are
/// kept under the hash of all that they depend on (the asset's bytes, the body's shape and placement, this build). A
/// second process that comes while the first still meshes waits for it. An entry that is damaged is made again. With an
/// empty folder: just mesh_body(). Errors: as mesh_body(); a folder that cannot be written is only not used.
/// Surfaces that are not filled are cheap and are made each time.
Result<MeshedBody> mesh_body_shared(const shots::Shot& shot, const shots::Body& body, Filling filling,
                                    const std::filesystem::path& folder);

/// A meshed body as bytes that carry their own check sum, and back. Errors: io when damaged.
std::string encode_meshed_body(const MeshedBody& body);
Result<MeshedBody> decode_meshed_body(const std::string& bytes, const std::string& name);

} // namespace wry::pipeline
