#pragma once

#include <string>

#include "sim/geometry/surface_mesh.h"

namespace wry::pipeline {

/// A folder of its own that goes away at the end.
class TemporaryFolder {
public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  /// Writes the bytes to a file of that name and gives back its path.
  std::string write(const std::string& name, const std::string& bytes) const;

private:
  std::string m_path;
};

/// The mesh as the bytes of a file. `kind`: obj, stl, stl-ascii, off, glb, ply-ascii, ply-little, ply-big.
std::string mesh_file_bytes(const geometry::SurfaceMesh& mesh, const std::string& kind);

/// The extension that belongs to a kind.
std::string extension_of(const std::string& kind);

} // namespace wry::pipeline
