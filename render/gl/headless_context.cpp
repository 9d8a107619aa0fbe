#include "render/gl/headless_context.h"

#include <cstdlib>

namespace wry::render {
namespace {

/// Mesa reads these once, when the first context of the process is made.
void prepare_environment(int raster_threads) {
  ::unsetenv("LP_NATIVE_VECTOR_WIDTH"); // 512 crashes llvmpipe
  ::setenv("LP_NUM_THREADS", std::to_string(raster_threads).c_str(), 1);
  ::setenv("LIBGL_ALWAYS_SOFTWARE", "1", 0); // EGL must draw what OSMesa draws, also where a GPU is
}

} // namespace

Status HeadlessContext::finish(std::string backend, const std::function<void*(const char*)>& look_up) {
  Result<GlFunctions> functions = load_gl_functions(look_up);
  if (!functions.ok())
    return functions.error();
  m_gl = *functions;
  const auto text = [this](GLenum what) {
    const GLubyte* value = m_gl.GetString(what);
    return value != nullptr ? std::string(reinterpret_cast<const char*>(value)) : std::string();
  };
  m_version = GlVersion{std::move(backend), text(GL_VERSION), text(GL_RENDERER)};
  if (m_version.version.empty())
    return make_error(ErrorCode::unavailable, "OpenGL answers nothing: the program must not be linked with libGL");
  return {};
}

Result<std::unique_ptr<HeadlessContext>> HeadlessContext::create(GlBackend backend, int raster_threads) {
  prepare_environment(raster_threads);
  if (backend == GlBackend::egl)
    return create_egl_context();
  Result<std::unique_ptr<HeadlessContext>> first = create_osmesa_context();
  if (first.ok() || backend == GlBackend::osmesa)
    return first;
  Result<std::unique_ptr<HeadlessContext>> second = create_egl_context();
  if (second.ok())
    return second;
  return make_error(ErrorCode::unavailable, "no way to draw without a display: {}; {}", first.error().message,
                    second.error().message);
}

} // namespace wry::render
