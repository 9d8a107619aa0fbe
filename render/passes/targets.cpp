#include "render/passes/pass.h"

#include <cstddef>

namespace wry::render {

Result<Targets> make_targets(const GlFunctions& gl, const ImageSize& size) {
  GLint side_max = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &side_max);
  if (size.width > side_max || size.height > side_max)
    return make_error(ErrorCode::bad_input, "a picture of {} x {} pixels: this OpenGL draws at most {} on a side",
                      size.width, size.height, side_max);
  Targets targets;
  targets.size = size;
  targets.half_size = {(size.width + 1) / 2, (size.height + 1) / 2};
  targets.surface = make_texture(gl, GL_RG32UI, size.width, size.height, TextureFilter::nearest);
  targets.depth = make_texture(gl, GL_DEPTH_COMPONENT32F, size.width, size.height, TextureFilter::nearest);
  targets.shadow =
      make_texture(gl, GL_DEPTH_COMPONENT32F, SHADOW_MAP_SIZE, SHADOW_MAP_SIZE, TextureFilter::shadow_compare);
  targets.occlusion = make_texture(gl, GL_RGBA8, size.width, size.height, TextureFilter::nearest);
  targets.accumulation = make_texture(gl, GL_RGBA16F, size.width, size.height, TextureFilter::nearest);
  targets.display = make_texture(gl, GL_RGBA8, size.width, size.height, TextureFilter::nearest);
  if (gl.GetError() != GL_NO_ERROR)
    return make_error(ErrorCode::out_of_memory, "no memory for the layers of a picture of {} x {} pixels", size.width,
                      size.height);
  const auto attach = [&](GlObject& frame, const GlObject* color, const GlObject* depth) -> Status {
    Result<GlObject> made =
        make_framebuffer(gl, color != nullptr ? color->name() : 0, depth != nullptr ? depth->name() : 0);
    if (!made.ok())
      return made.error();
    frame = std::move(*made);
    return {};
  };
  for (const Status& status : {attach(targets.surface_frame, &targets.surface, &targets.depth),
                               attach(targets.shadow_frame, nullptr, &targets.shadow),
                               attach(targets.accumulation_frame, &targets.accumulation, &targets.depth),
                               attach(targets.display_frame, &targets.display, nullptr)}) {
    if (!status.ok())
      return status.error();
  }
  return targets;
}

void draw_in_rect(const GlFunctions& gl, const PixelRect& rect) {
  if (rect.width <= 0 || rect.height <= 0)
    return;
  gl.Enable(GL_SCISSOR_TEST);
  gl.Scissor(rect.x, rect.y, rect.width, rect.height);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  gl.Disable(GL_SCISSOR_TEST);
}

Geometry::Geometry(const GlFunctions& gl)
    : m_gl(gl)
    , m_vertices(make_buffer(gl))
    , m_indices(make_buffer(gl))
    , m_array(make_vertex_array(gl)) {
  const GLuint array = m_array.name();
  gl.VertexArrayVertexBuffer(array, 0, m_vertices.name(), 0, sizeof(DrawVertex));
  gl.VertexArrayElementBuffer(array, m_indices.name());
  gl.VertexArrayAttribFormat(array, 0, 3, GL_FLOAT, GL_FALSE, offsetof(DrawVertex, position));
  gl.VertexArrayAttribFormat(array, 1, 3, GL_FLOAT, GL_FALSE, offsetof(DrawVertex, normal));
  gl.VertexArrayAttribIFormat(array, 2, 1, GL_UNSIGNED_INT, offsetof(DrawVertex, look));
  gl.VertexArrayAttribFormat(array, 3, 1, GL_FLOAT, GL_FALSE, offsetof(DrawVertex, value));
  for (GLuint attribute = 0; attribute < 4; ++attribute) {
    gl.VertexArrayAttribBinding(array, attribute, 0);
    gl.EnableVertexArrayAttrib(array, attribute);
  }
}

void Geometry::upload(const DrawList& list) {
  const auto bytes = [](const auto& values) { return static_cast<GLsizeiptr>(values.size() * sizeof(values.front())); };
  m_gl.NamedBufferData(m_vertices.name(), bytes(list.vertices), list.vertices.data(), GL_STREAM_DRAW);
  m_gl.NamedBufferData(m_indices.name(), bytes(list.indices), list.indices.data(), GL_STREAM_DRAW);
  m_indexed = !list.indices.empty();
  m_count = static_cast<GLsizei>(m_indexed ? list.indices.size() : list.vertices.size());
}

void Geometry::draw() const {
  m_gl.BindVertexArray(m_array.name());
  if (m_indexed)
    m_gl.DrawElements(GL_TRIANGLES, m_count, GL_UNSIGNED_INT, nullptr);
  else
    m_gl.DrawArrays(GL_TRIANGLES, 0, m_count);
}

} // namespace wry::render
