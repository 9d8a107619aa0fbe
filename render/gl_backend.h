#pragma once

#include <string_view>

#include "sim/base/result.h"

namespace wry::render {

/// Which library makes the OpenGL context. The pixels are the same.
enum class GlBackend { automatic, osmesa, egl };

/// "auto" (OSMesa, else EGL), "osmesa" or "egl". Errors: usage.
Result<GlBackend> parse_gl_backend(std::string_view name);

/// What draws the pictures on this machine, for provenance and for golden images.
struct GlVersion {
  std::string backend;  ///< "osmesa" or "egl"
  std::string version;  ///< GL_VERSION, with Mesa's version
  std::string renderer; ///< GL_RENDERER, with the vector width
};

} // namespace wry::render
