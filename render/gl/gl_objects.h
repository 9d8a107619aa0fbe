#pragma once

#include <string>
#include <utility>

#include <Eigen/Core>

#include "render/gl/gl_functions.h"

namespace wry::render {

/// An OpenGL name that is deleted with its owner. The context must outlive it.
class GlObject {
public:
  using Deleter = void (*)(const GlFunctions&, GLuint);
  GlObject() = default;
  GlObject(const GlFunctions& gl, GLuint name, Deleter deleter)
      : m_gl(&gl)
      , m_name(name)
      , m_deleter(deleter) {}
  GlObject(GlObject&& other) noexcept { swap(other); }
  GlObject& operator=(GlObject&& other) noexcept {
    GlObject taken(std::move(other));
    swap(taken);
    return *this;
  }
  GlObject(const GlObject&) = delete;
  GlObject& operator=(const GlObject&) = delete;
  ~GlObject() {
    if (m_name != 0)
      m_deleter(*m_gl, m_name);
  }
  GLuint name() const { return m_name; }

private:
  void swap(GlObject& other) noexcept {
    std::swap(m_gl, other.m_gl);
    std::swap(m_name, other.m_name);
    std::swap(m_deleter, other.m_deleter);
  }
  const GlFunctions* m_gl = nullptr;
  GLuint m_name = 0;
  Deleter m_deleter = nullptr;
};

enum class TextureFilter { nearest, linear, shadow_compare };

/// One level of 2D texture, clamped to its edge (a shadow map: to its border, which is lit).
GlObject make_texture(const GlFunctions& gl, GLenum format, int width, int height, TextureFilter filter);

/// A framebuffer of one colour texture and one depth texture; 0 means none. Errors: unavailable with GL's reason.
Result<GlObject> make_framebuffer(const GlFunctions& gl, GLuint color, GLuint depth);

GlObject make_buffer(const GlFunctions& gl);
GlObject make_vertex_array(const GlFunctions& gl);

/// A linked program and its uniforms by name. A name that the compiler dropped is ignored, as OpenGL does.
class Program {
public:
  /// Errors: unavailable with the compiler's log; our own shaders compile on every Mesa we support.
  static Result<Program> create(const GlFunctions& gl, const std::string& what, const std::string& vertex_source,
                                const std::string& fragment_source);

  void use() const { m_gl->UseProgram(m_object.name()); }
  void set(const char* name, int value) const { m_gl->Uniform1i(location(name), value); }
  void set(const char* name, float value) const { m_gl->Uniform1f(location(name), value); }
  void set(const char* name, const Eigen::Vector2f& v) const { m_gl->Uniform2f(location(name), v.x(), v.y()); }
  void set(const char* name, const Eigen::Vector3f& v) const { m_gl->Uniform3f(location(name), v.x(), v.y(), v.z()); }
  void set(const char* name, const Eigen::Matrix4f& matrix) const {
    m_gl->UniformMatrix4fv(location(name), 1, GL_FALSE, matrix.data());
  }
  /// `values`: a column per entry.
  void set_array(const char* name, const Eigen::Ref<const Eigen::Matrix4Xf>& values) const {
    m_gl->Uniform4fv(location(name), static_cast<GLsizei>(values.cols()), values.data());
  }

private:
  GLint location(const char* name) const { return m_gl->GetUniformLocation(m_object.name(), name); }
  const GlFunctions* m_gl = nullptr;
  GlObject m_object;
};

/// Vertex shader of a triangle that covers the viewport, at depth 0: the far plane of a picture with reversed depth.
extern const char* const FULL_SCREEN_VERTEX_SHADER;

} // namespace wry::render
