#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace wry::layering {

/// An #include that the house does not allow, or a header that breaks a rule of its own.
struct Violation {
  std::string file; ///< relative to the root
  int line = 0;     ///< from 1; 0 for the whole file
  std::string what;
};

/// Walks every .h and .cpp under the rooms (sim, shots, render, pipeline) and tests of `root` and checks:
/// - the arrows between the rooms, and between the parts of pipeline;
/// - that an #include "..." names a file from the root that is there;
/// - that no header of ours includes one of OpenVDB, assimp, HDF5, SuiteSparse, OSMesa/GL/EGL, toml++, CLI11, muParser
/// ... (render/gl may name GL, and
///   stays within render);
/// - that every header starts with #pragma once;
/// - that kernel files include neither Eigen nor our headers that do.
std::vector<Violation> check_includes(const std::filesystem::path& root);

/// How many files check_includes() looks at.
std::size_t count_sources(const std::filesystem::path& root);

} // namespace wry::layering
