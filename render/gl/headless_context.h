#pragma once

#include <memory>
#include <string>

#include "render/gl/gl_functions.h"
#include "render/gl_backend.h"

namespace wry::render {

/// An OpenGL 4.5 core context without a window; current on the thread that made it. Draw into framebuffer objects only.
class HeadlessContext {
public:
  /// `raster_threads`: llvmpipe's own threads. 0 (the caller draws) is right for one process per core, and the only
  /// number with which a process may fork later. It counts for the first context of a process only.
  /// Errors: unavailable, naming the package to install.
  static Result<std::unique_ptr<HeadlessContext>> create(GlBackend backend, int raster_threads);

  virtual ~HeadlessContext() = default;

  const GlFunctions& gl() const { return m_gl; }
  const GlVersion& version() const { return m_version; }

protected:
  Status finish(std::string backend, const std::function<void*(const char*)>& look_up);

private:
  GlFunctions m_gl;
  GlVersion m_version;
};

/// The two ways; HeadlessContext::create chooses.
Result<std::unique_ptr<HeadlessContext>> create_osmesa_context();
Result<std::unique_ptr<HeadlessContext>> create_egl_context();

} // namespace wry::render
