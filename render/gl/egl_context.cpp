#include <array>
#include <cstdint>

#include <dlfcn.h>

#include "render/gl/headless_context.h"

namespace wry::render {
namespace {

// The few names of EGL 1.5 that are used, from the Khronos registry.
using EglHandle = void*;
constexpr unsigned EGL_PLATFORM_SURFACELESS_MESA = 0x31DD;
constexpr unsigned EGL_OPENGL_API = 0x30A2;
constexpr std::int32_t EGL_CONTEXT_MAJOR_VERSION = 0x3098;
constexpr std::int32_t EGL_CONTEXT_MINOR_VERSION = 0x30FB;
constexpr std::int32_t EGL_CONTEXT_OPENGL_PROFILE_MASK = 0x30FD;
constexpr std::int32_t EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT = 1;
constexpr std::int32_t EGL_NONE = 0x3038;

struct EglLibrary {
  void* (*get_proc_address)(const char*) = nullptr;
  EglHandle (*get_platform_display)(unsigned, void*, const std::intptr_t*) = nullptr;
  unsigned (*initialize)(EglHandle, std::int32_t*, std::int32_t*) = nullptr;
  unsigned (*bind_api)(unsigned) = nullptr;
  EglHandle (*create_context)(EglHandle, EglHandle, EglHandle, const std::int32_t*) = nullptr;
  unsigned (*make_current)(EglHandle, EglHandle, EglHandle, EglHandle) = nullptr;
  unsigned (*destroy_context)(EglHandle, EglHandle) = nullptr;
  std::int32_t (*get_error)() = nullptr;
};

Result<EglLibrary> load_library() {
  void* library = ::dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr)
    return make_error(ErrorCode::unavailable,
                      "EGL is not installed ({}): install the Debian packages libegl1 and libegl-mesa0", ::dlerror());
  EglLibrary egl;
  const auto find = [library](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(::dlsym(library, name));
    return function != nullptr;
  };
  const bool whole = find(egl.get_proc_address, "eglGetProcAddress") &&
                     find(egl.get_platform_display, "eglGetPlatformDisplay") && find(egl.initialize, "eglInitialize") &&
                     find(egl.bind_api, "eglBindAPI") && find(egl.create_context, "eglCreateContext") &&
                     find(egl.make_current, "eglMakeCurrent") && find(egl.destroy_context, "eglDestroyContext") &&
                     find(egl.get_error, "eglGetError");
  if (!whole)
    return make_error(ErrorCode::unavailable, "libEGL.so.1 is older than EGL 1.5: install libegl1 and libegl-mesa0");
  return egl;
}

class EglHeadlessContext final : public HeadlessContext {
public:
  explicit EglHeadlessContext(const EglLibrary& library)
      : m_egl(library) {}
  ~EglHeadlessContext() override {
    if (m_context != nullptr) {
      m_egl.make_current(m_display, nullptr, nullptr, nullptr);
      m_egl.destroy_context(m_display, m_context);
    }
  }

  Status start() {
    m_display = m_egl.get_platform_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
    std::int32_t major = 0;
    std::int32_t minor = 0;
    if (m_display == nullptr || m_egl.initialize(m_display, &major, &minor) == 0)
      return failed("start Mesa's surfaceless display");
    if (m_egl.bind_api(EGL_OPENGL_API) == 0)
      return failed("choose OpenGL");
    const std::array<std::int32_t, 7> attributes = {
        EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    m_context = m_egl.create_context(m_display, nullptr, nullptr, attributes.data());
    if (m_context == nullptr)
      return failed("make an OpenGL 4.5 core context");
    if (m_egl.make_current(m_display, nullptr, nullptr, m_context) == 0)
      return failed("make its context current without a surface");
    return finish("egl", m_egl.get_proc_address);
  }

private:
  Status failed(const char* what) const {
    return make_error(ErrorCode::unavailable,
                      "EGL cannot {} (error {:#x}): install libegl1 and libegl-mesa0 22 or newer", what,
                      m_egl.get_error());
  }

  EglLibrary m_egl;
  EglHandle m_display = nullptr;
  EglHandle m_context = nullptr;
};

} // namespace

Result<std::unique_ptr<HeadlessContext>> create_egl_context() {
  const Result<EglLibrary> library = load_library();
  if (!library.ok())
    return library.error();
  auto context = std::make_unique<EglHeadlessContext>(*library);
  if (const Status started = context->start(); !started.ok())
    return started.error();
  return std::unique_ptr<HeadlessContext>(std::move(context));
}

} // namespace wry::render
