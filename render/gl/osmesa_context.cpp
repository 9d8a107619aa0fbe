#include <array>

#include <dlfcn.h>

#include "render/gl/headless_context.h"

namespace wry::render {
namespace {

// OSMesa's own interface, as its ABI has been since Mesa 11.2.
constexpr int OSMESA_FORMAT = 0x22;
constexpr int OSMESA_DEPTH_BITS = 0x30;
constexpr int OSMESA_STENCIL_BITS = 0x31;
constexpr int OSMESA_ACCUM_BITS = 0x32;
constexpr int OSMESA_PROFILE = 0x33;
constexpr int OSMESA_CORE_PROFILE = 0x34;
constexpr int OSMESA_CONTEXT_MAJOR_VERSION = 0x36;
constexpr int OSMESA_CONTEXT_MINOR_VERSION = 0x37;
using OSMesaContext = void*;

struct OSMesaLibrary {
  OSMesaContext (*create)(const int*, OSMesaContext) = nullptr;
  unsigned char (*make_current)(OSMesaContext, void*, GLenum, int, int) = nullptr;
  void (*destroy)(OSMesaContext) = nullptr;
  void* (*get_proc_address)(const char*) = nullptr;
};

Result<OSMesaLibrary> load_library() {
  // Local, so that its gl* names never mix with libGL's; never closed, Mesa leaves handlers behind.
  void* library = ::dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr)
    return make_error(ErrorCode::unavailable, "OSMesa is not installed ({}): install the Debian package libosmesa6",
                      ::dlerror());
  OSMesaLibrary found;
  found.create = reinterpret_cast<decltype(found.create)>(::dlsym(library, "OSMesaCreateContextAttribs"));
  found.make_current = reinterpret_cast<decltype(found.make_current)>(::dlsym(library, "OSMesaMakeCurrent"));
  found.destroy = reinterpret_cast<decltype(found.destroy)>(::dlsym(library, "OSMesaDestroyContext"));
  found.get_proc_address = reinterpret_cast<decltype(found.get_proc_address)>(::dlsym(library, "OSMesaGetProcAddress"));
  if (!found.create || !found.make_current || !found.destroy || !found.get_proc_address)
    return make_error(ErrorCode::unavailable, "libOSMesa.so.8 lacks OSMesaCreateContextAttribs: install libosmesa6 of "
                                              "Mesa 22 or newer");
  return found;
}

class OSMesaHeadlessContext final : public HeadlessContext {
public:
  explicit OSMesaHeadlessContext(const OSMesaLibrary& library)
      : m_library(library) {}
  ~OSMesaHeadlessContext() override {
    if (m_context != nullptr)
      m_library.destroy(m_context);
  }

  Status start() {
    const std::array<int, 15> attributes = {OSMESA_FORMAT,
                                            0x1908, // GL_RGBA
                                            OSMESA_DEPTH_BITS,
                                            0,
                                            OSMESA_STENCIL_BITS,
                                            0,
                                            OSMESA_ACCUM_BITS,
                                            0,
                                            OSMESA_PROFILE,
                                            OSMESA_CORE_PROFILE,
                                            OSMESA_CONTEXT_MAJOR_VERSION,
                                            4,
                                            OSMESA_CONTEXT_MINOR_VERSION,
                                            5,
                                            0};
    m_context = m_library.create(attributes.data(), nullptr);
    if (m_context == nullptr)
      return make_error(ErrorCode::unavailable,
                        "OSMesa cannot make an OpenGL 4.5 core context: Mesa 22 or newer is needed");
    if (m_library.make_current(m_context, m_unused.data(), GL_UNSIGNED_BYTE, 16, 16) == 0)
      return make_error(ErrorCode::unavailable, "OSMesa cannot make its context current");
    return finish("osmesa", m_library.get_proc_address);
  }

private:
  OSMesaLibrary m_library;
  OSMesaContext m_context = nullptr;
  std::array<unsigned char, 16 * 16 * 4> m_unused{}; ///< OSMesa insists on a window; nothing is drawn there
};

} // namespace

Result<std::unique_ptr<HeadlessContext>> create_osmesa_context() {
  const Result<OSMesaLibrary> library = load_library();
  if (!library.ok())
    return library.error();
  auto context = std::make_unique<OSMesaHeadlessContext>(*library);
  if (const Status started = context->start(); !started.ok())
    return started.error();
  return std::unique_ptr<HeadlessContext>(std::move(context));
}

} // namespace wry::render
