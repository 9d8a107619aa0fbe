#include "render/gl/gl_functions.h"

namespace wry::render {

Result<GlFunctions> load_gl_functions(const std::function<void*(const char*)>& look_up) {
  GlFunctions functions;
#define WRY_GL_LOAD(type, name)                                                                                        \
  functions.name = reinterpret_cast<PFNGL##type##PROC>(look_up("gl" #name));                                           \
  if (functions.name == nullptr)                                                                                       \
    return make_error(ErrorCode::unavailable,                                                                          \
                      "this OpenGL has no function gl{}: version 4.5 core is needed; install Mesa 22 or newer",        \
                      #name);
  WRY_GL_FUNCTIONS(WRY_GL_LOAD)
#undef WRY_GL_LOAD
  return functions;
}

} // namespace wry::render
