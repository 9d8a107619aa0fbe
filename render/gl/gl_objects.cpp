#include "render/gl/gl_objects.h"

#include <array>

namespace wry::render {

const char* const FULL_SCREEN_VERTEX_SHADER = R"(#version 450 core
void main() {
  vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
})";

GlObject make_texture(const GlFunctions& gl, GLenum format, int width, int height, TextureFilter filter) {
  GLuint name = 0;
  gl.CreateTextures(GL_TEXTURE_2D, 1, &name);
  gl.TextureStorage2D(name, 1, format, width, height);
  const GLint sampling = filter == TextureFilter::nearest ? GL_NEAREST : GL_LINEAR;
  gl.TextureParameteri(name, GL_TEXTURE_MIN_FILTER, sampling);
  gl.TextureParameteri(name, GL_TEXTURE_MAG_FILTER, sampling);
  const GLint wrap = filter == TextureFilter::shadow_compare ? GL_CLAMP_TO_BORDER : GL_CLAMP_TO_EDGE;
  gl.TextureParameteri(name, GL_TEXTURE_WRAP_S, wrap);
  gl.TextureParameteri(name, GL_TEXTURE_WRAP_T, wrap);
  if (filter == TextureFilter::shadow_compare) {
    const std::array<float, 4> farthest = {1.f, 1.f, 1.f, 1.f};
    gl.TextureParameterfv(name, GL_TEXTURE_BORDER_COLOR, farthest.data());
    gl.TextureParameteri(name, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    gl.TextureParameteri(name, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  }
  return GlObject(gl, name, [](const GlFunctions& f, GLuint n) { f.DeleteTextures(1, &n); });
}

Result<GlObject> make_framebuffer(const GlFunctions& gl, GLuint color, GLuint depth) {
  GLuint name = 0;
  gl.CreateFramebuffers(1, &name);
  GlObject object(gl, name, [](const GlFunctions& f, GLuint n) { f.DeleteFramebuffers(1, &n); });
  if (color != 0)
    gl.NamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, color, 0);
  if (depth != 0)
    gl.NamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, depth, 0);
  gl.NamedFramebufferDrawBuffer(name, color != 0 ? GL_COLOR_ATTACHMENT0 : GL_NONE);
  const GLenum status = gl.CheckNamedFramebufferStatus(name, GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE)
    return make_error(ErrorCode::unavailable, "OpenGL refuses a framebuffer (status {:#x}, error {:#x})", status,
                      gl.GetError());
  return object;
}

GlObject make_buffer(const GlFunctions& gl) {
  GLuint name = 0;
  gl.CreateBuffers(1, &name);
  return GlObject(gl, name, [](const GlFunctions& f, GLuint n) { f.DeleteBuffers(1, &n); });
}

GlObject make_vertex_array(const GlFunctions& gl) {
  GLuint name = 0;
  gl.CreateVertexArrays(1, &name);
  return GlObject(gl, name, [](const GlFunctions& f, GLuint n) { f.DeleteVertexArrays(1, &n); });
}

namespace {

Result<GlObject> compile(const GlFunctions& gl, const std::string& what, GLenum kind, const std::string& source) {
  GlObject shader(gl, gl.CreateShader(kind), [](const GlFunctions& f, GLuint n) { f.DeleteShader(n); });
  const char* text = source.c_str();
  gl.ShaderSource(shader.name(), 1, &text, nullptr);
  gl.CompileShader(shader.name());
  GLint good = 0;
  gl.GetShaderiv(shader.name(), GL_COMPILE_STATUS, &good);
  if (good == 0) {
    std::array<char, 2048> log{};
    gl.GetShaderInfoLog(shader.name(), static_cast<GLsizei>(log.size()), nullptr, log.data());
    return make_error(ErrorCode::unavailable, "the {} shader does not compile on this OpenGL: {}", what, log.data());
  }
  return shader;
}

} // namespace

Result<Program> Program::create(const GlFunctions& gl, const std::string& what, const std::string& vertex_source,
                                const std::string& fragment_source) {
  const Result<GlObject> vertex = compile(gl, what + " vertex", GL_VERTEX_SHADER, vertex_source);
  if (!vertex.ok())
    return vertex.error();
  const Result<GlObject> fragment = compile(gl, what + " fragment", GL_FRAGMENT_SHADER, fragment_source);
  if (!fragment.ok())
    return fragment.error();
  Program program;
  program.m_gl = &gl;
  program.m_object = GlObject(gl, gl.CreateProgram(), [](const GlFunctions& f, GLuint n) { f.DeleteProgram(n); });
  gl.AttachShader(program.m_object.name(), vertex->name());
  gl.AttachShader(program.m_object.name(), fragment->name());
  gl.LinkProgram(program.m_object.name());
  GLint good = 0;
  gl.GetProgramiv(program.m_object.name(), GL_LINK_STATUS, &good);
  if (good == 0) {
    std::array<char, 2048> log{};
    gl.GetProgramInfoLog(program.m_object.name(), static_cast<GLsizei>(log.size()), nullptr, log.data());
    return make_error(ErrorCode::unavailable, "the {} shader does not link on this OpenGL: {}", what, log.data());
  }
  return program;
}

} // namespace wry::render
