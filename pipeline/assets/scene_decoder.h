#pragma once

#include <map>
#include <string>

#include "pipeline/assets/import_protocol.h"

namespace wry::pipeline {

/// A mesh file in memory, with the files that it names.
struct MeshFile {
  std::string name;                         ///< without folders
  std::string extension;                    ///< lower case, without the dot
  std::map<std::string, std::string> files; ///< name -> bytes; the file itself is one of them
  std::string node;                         ///< only what hangs from the node of this name; empty: all
  ImportWhat what = ImportWhat::mesh;
};

/// Triangles of all meshes of a scene file, with node transforms applied; vertex colours as "colour", texture
/// coordinates as "uv". To be called in an import process only: the library behind it must be expected to crash on
/// damaged files. Errors: bad_input with the library's words; for an unknown node with the names there are; unavailable
/// in a build without it.
/// When the motion is wanted there are no triangles, but where the node is over the file's first animation.
Result<RawMesh> decode_scene(const MeshFile& file);

} // namespace wry::pipeline
