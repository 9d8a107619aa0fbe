#include "render/gl_backend.h"

namespace wry::render {

Result<GlBackend> parse_gl_backend(std::string_view name) {
  if (name == "auto")
    return GlBackend::automatic;
  if (name == "osmesa")
    return GlBackend::osmesa;
  if (name == "egl")
    return GlBackend::egl;
  return make_error(ErrorCode::usage, "--gl {}: not known; choose osmesa, egl or auto", name);
}

} // namespace wry::render
