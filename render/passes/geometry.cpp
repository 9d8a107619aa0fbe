#include "render/passes/pass.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

namespace wry::render {
namespace {

template <class Values> GLsizeiptr bytes(const Values& values) {
  return static_cast<GLsizeiptr>(values.size() * sizeof(typename Values::value_type));
}

template <class Values> void fill(const GlFunctions& gl, const GlObject& buffer, const Values& values) {
  gl.NamedBufferData(buffer.name(), bytes(values), values.data(), GL_STREAM_DRAW);
}

void attribute(const GlFunctions& gl, GLuint array, GLuint index, GLuint binding) {
  gl.VertexArrayAttribBinding(array, index, binding);
  gl.EnableVertexArrayAttrib(array, index);
}

void describe_grains(const GlFunctions& gl, const GlObject& array, const GlObject& vertices, const GlObject& indices) {
  gl.VertexArrayVertexBuffer(array.name(), 0, vertices.name(), 0, sizeof(GrainVertex));
  gl.VertexArrayElementBuffer(array.name(), indices.name());
  gl.VertexArrayAttribFormat(array.name(), 0, 3, GL_FLOAT, GL_FALSE, offsetof(GrainVertex, position));
  gl.VertexArrayAttribIFormat(array.name(), 1, 1, GL_UNSIGNED_INT, offsetof(GrainVertex, normal));
  gl.VertexArrayAttribIFormat(array.name(), 2, 1, GL_UNSIGNED_INT, offsetof(GrainVertex, word));
  for (GLuint index = 0; index < 3; ++index)
    attribute(gl, array.name(), index, 0);
}

/// OpenGL takes the place of the first index within its buffer [indices] as a pointer.
const void* index_offset(std::size_t first) {
  return reinterpret_cast<const void*>(first * sizeof(std::uint32_t)); // NOLINT(performance-no-int-to-ptr)
}

constexpr GLuint VELOCITY = 5;
constexpr GLuint UV = 6;
constexpr GLuint GRAIN_DATA = 7;

/// A picture with its smaller copies, so that far away it does not glitter.
GlObject make_picture(const GlFunctions& gl, const Image& image) {
  GLuint name = 0;
  gl.CreateTextures(GL_TEXTURE_2D, 1, &name);
  int levels = 1;
  while ((std::max(image.width, image.height) >> levels) > 0)
    ++levels;
  gl.TextureStorage2D(name, levels, GL_SRGB8_ALPHA8, image.width, image.height);
  gl.TextureSubImage2D(name, 0, 0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels.data());
  gl.GenerateTextureMipmap(name);
  gl.TextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  gl.TextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TextureParameteri(name, GL_TEXTURE_WRAP_S, GL_REPEAT);
  gl.TextureParameteri(name, GL_TEXTURE_WRAP_T, GL_REPEAT);
  return GlObject(gl, name, [](const GlFunctions& f, GLuint n) { f.DeleteTextures(1, &n); });
}

} // namespace

Geometry::Geometry(const GlFunctions& gl, const std::vector<Image>& textures)
    : m_gl(gl)
    , m_vertices(make_buffer(gl))
    , m_indices(make_buffer(gl))
    , m_velocities(make_buffer(gl))
    , m_uvs(make_buffer(gl))
    , m_array(make_vertex_array(gl))
    , m_boxes(make_buffer(gl))
    , m_box_indices(make_buffer(gl))
    , m_box_array(make_vertex_array(gl))
    , m_rounds(make_buffer(gl))
    , m_round_indices(make_buffer(gl))
    , m_round_array(make_vertex_array(gl))
    , m_box_data(make_buffer(gl))
    , m_round_data(make_buffer(gl))
    , m_outlines(make_buffer(gl))
    , m_outline_indices(make_buffer(gl))
    , m_outline_array(make_vertex_array(gl))
    , m_chosen_indices(make_buffer(gl)) {
  const GLuint array = m_array.name();
  gl.VertexArrayVertexBuffer(array, 0, m_vertices.name(), 0, sizeof(DrawVertex));
  gl.VertexArrayVertexBuffer(array, 1, m_velocities.name(), 0, sizeof(std::array<float, 3>));
  gl.VertexArrayVertexBuffer(array, 2, m_uvs.name(), 0, sizeof(std::array<float, 2>));
  gl.VertexArrayElementBuffer(array, m_indices.name());
  gl.VertexArrayAttribFormat(array, 0, 3, GL_FLOAT, GL_FALSE, offsetof(DrawVertex, position));
  gl.VertexArrayAttribFormat(array, 1, 3, GL_FLOAT, GL_FALSE, offsetof(DrawVertex, normal));
  gl.VertexArrayAttribIFormat(array, 2, 1, GL_UNSIGNED_INT, offsetof(DrawVertex, look));
  gl.VertexArrayAttribFormat(array, 3, 1, GL_FLOAT, GL_FALSE, offsetof(DrawVertex, value));
  gl.VertexArrayAttribFormat(array, 4, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(DrawVertex, tint));
  for (GLuint index = 0; index < 5; ++index)
    attribute(gl, array, index, 0);
  gl.VertexArrayAttribFormat(array, VELOCITY, 3, GL_FLOAT, GL_FALSE, 0);
  gl.VertexArrayAttribBinding(array, VELOCITY, 1);
  gl.VertexArrayAttribFormat(array, UV, 2, GL_FLOAT, GL_FALSE, 0);
  gl.VertexArrayAttribBinding(array, UV, 2);
  describe_grains(gl, m_box_array, m_boxes, m_box_indices);
  describe_grains(gl, m_round_array, m_rounds, m_round_indices);
  gl.VertexArrayVertexBuffer(m_outline_array.name(), 0, m_outlines.name(), 0, sizeof(std::array<float, 3>));
  gl.VertexArrayElementBuffer(m_outline_array.name(), m_outline_indices.name());
  gl.VertexArrayAttribFormat(m_outline_array.name(), 0, 3, GL_FLOAT, GL_FALSE, 0);
  attribute(gl, m_outline_array.name(), 0, 0);
  for (const Image& texture : textures)
    m_textures.push_back(make_picture(gl, texture));
}

void Geometry::upload(DrawList&& list) {
  upload_triangles(list);
  m_clouds = std::move(list.clouds);
  m_places.clear();
  m_in_sight.clear();
  m_eye_ready = false;
  m_light_ready = false;
}

void Geometry::upload_triangles(const DrawList& list) {
  fill(m_gl, m_vertices, list.vertices);
  fill(m_gl, m_indices, list.indices);
  m_indexed = !list.indices.empty();
  const std::size_t corners = m_indexed ? list.indices.size() : list.vertices.size();
  m_count = static_cast<GLsizei>(std::min(corners, list.clear_begin));
  m_outward_count = static_cast<GLsizei>(std::min(list.outward_end, static_cast<std::size_t>(m_count)));
  m_clear_count = static_cast<GLsizei>(corners) - m_count;
  m_ranges = list.textured;
  const auto optional = [&](GLuint index, const GlObject& buffer, const auto& values) {
    if (values.empty()) {
      m_gl.DisableVertexArrayAttrib(m_array.name(), index); // reads as zero
      return;
    }
    fill(m_gl, buffer, values);
    m_gl.EnableVertexArrayAttrib(m_array.name(), index);
  };
  optional(VELOCITY, m_velocities, list.velocities);
  optional(UV, m_uvs, list.uvs);
}

void Geometry::draw_corners(std::size_t begin, std::size_t end) const {
  if (begin >= end)
    return;
  if (m_indexed)
    m_gl.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(end - begin), GL_UNSIGNED_INT, index_offset(begin));
  else
    m_gl.DrawArrays(GL_TRIANGLES, static_cast<GLint>(begin), static_cast<GLsizei>(end - begin));
}

void Geometry::draw_outward() const {
  m_gl.Enable(GL_CULL_FACE);
  m_gl.CullFace(GL_BACK);
  draw_corners(0, static_cast<std::size_t>(m_outward_count));
  m_gl.Disable(GL_CULL_FACE);
}

void Geometry::draw() const {
  m_gl.BindVertexArray(m_array.name());
  draw_outward();
  draw_corners(static_cast<std::size_t>(m_outward_count), static_cast<std::size_t>(m_count));
}

void Geometry::draw_clear() const {
  m_gl.BindVertexArray(m_array.name());
  m_gl.DrawElements(GL_TRIANGLES, m_clear_count, GL_UNSIGNED_INT, index_offset(static_cast<std::size_t>(m_count)));
}

void Geometry::draw_textured(const std::function<void(GLuint)>& bind) const {
  m_gl.BindVertexArray(m_array.name());
  const auto draw_range = [&](std::uint32_t begin, std::uint32_t end, GLuint texture) {
    if (begin >= end)
      return;
    bind(texture);
    draw_corners(begin, end);
  };
  auto done = static_cast<std::uint32_t>(m_outward_count);
  if (done > 0) {
    bind(0);
    draw_outward();
  }
  for (const TexturedRange& range : m_ranges) {
    draw_range(done, range.begin, 0);
    draw_range(range.begin, range.end, m_textures[range.texture].name());
    done = range.end;
  }
  draw_range(done, static_cast<std::uint32_t>(m_count), 0);
}

void Geometry::grow_pattern(const GlObject& buffer, std::span<const std::uint32_t> pattern, std::uint32_t vertices,
                            std::size_t count, std::size_t& held) {
  if (count <= held)
    return;
  std::vector<std::uint32_t> indices;
  indices.reserve(count * pattern.size());
  for (std::size_t i = 0; i < count; ++i) {
    for (const std::uint32_t index : pattern)
      indices.push_back(static_cast<std::uint32_t>(i) * vertices + index);
  }
  fill(m_gl, buffer, indices);
  held = count;
}

void Geometry::face_eye(const Eigen::Vector3f& eye, float seconds) {
  if (m_clouds.empty() || (m_eye_ready && seconds == m_eye_seconds))
    return;
  const ViewPoint from{ViewPoint::Kind::place, eye};
  m_box_vertices.clear();
  m_round_triangles.vertices.clear();
  m_round_triangles.indices.clear();
  for (std::size_t c = 0; c < m_clouds.size(); ++c) {
    const DrawCloud& cloud = m_clouds[c];
    if (cloud.seen_by == DrawCloud::For::light)
      continue;
    const std::vector<DrawGrain>& grains = m_in_sight.empty() ? cloud.grains : m_in_sight[c];
    if (cloud.segments == 0)
      append_boxes(grains, from, seconds, m_box_vertices);
    else if (cloud.shape == GrainShape::sphere)
      append_spheres(grains, cloud.segments, from, seconds, m_round_triangles);
    else
      append_cylinders(grains, cloud.shape, cloud.segments, from, seconds, m_round_triangles);
  }
  fill(m_gl, m_boxes, m_box_vertices);
  fill(m_gl, m_rounds, m_round_triangles.vertices);
  fill(m_gl, m_round_indices, m_round_triangles.indices);
  const std::size_t boxes = m_box_vertices.size() / BOX_VERTICES;
  grow_pattern(m_box_indices, box_indices(), BOX_VERTICES, boxes, m_box_pattern);
  m_box_count = static_cast<GLsizei>(boxes * BOX_INDICES);
  m_round_count = static_cast<GLsizei>(m_round_triangles.indices.size());
  m_eye_ready = true;
  m_eye_seconds = seconds;
}

std::size_t Geometry::grains() const {
  std::size_t count = 0;
  for (const DrawCloud& cloud : m_clouds)
    count += cloud.seen_by == DrawCloud::For::light ? 0 : cloud.grains.size();
  return count;
}

void Geometry::show_first_met(const Eigen::Matrix4f& clip_from_world, const ImageSize& size) {
  m_in_sight.assign(m_clouds.size(), {});
  m_places.clear();
  for (std::size_t c = 0; c < m_clouds.size(); ++c) {
    const std::vector<DrawGrain>& grains = m_clouds[c].grains;
    m_places.emplace_back(grains.size(), Place::waiting);
    if (m_clouds[c].seen_by == DrawCloud::For::light)
      continue;
    const GrainPlaces places = grain_places(grains, clip_from_world, size);
    for (const std::uint32_t i : nearest_in_cells(places.places, places.side, FIRST_MET)) {
      m_places[c][i] = Place::shown;
      m_in_sight[c].push_back(grains[i]);
    }
  }
  m_eye_ready = false;
}

void Geometry::show_rest(const HidingPicture& drawn) {
  for (std::size_t c = 0; c < m_clouds.size(); ++c) {
    const std::vector<DrawGrain>& grains = m_clouds[c].grains;
    m_in_sight[c].clear();
    for (std::size_t i = 0; m_clouds[c].seen_by != DrawCloud::For::light && i < grains.size(); ++i) {
      if (m_places[c][i] != Place::waiting)
        continue;
      m_places[c][i] = drawn.hides(grains[i]) ? Place::hidden : Place::shown;
      if (m_places[c][i] == Place::shown)
        m_in_sight[c].push_back(grains[i]);
    }
  }
  m_eye_ready = false;
}

void Geometry::show_seen(const HidingPicture& drawn) {
  m_in_sight.assign(m_clouds.size(), {});
  for (std::size_t c = 0; c < m_clouds.size(); ++c) {
    const std::vector<DrawGrain>& grains = m_clouds[c].grains;
    for (std::size_t i = 0; m_clouds[c].seen_by != DrawCloud::For::light && i < grains.size(); ++i) {
      const bool known = !m_places.empty() && m_places[c][i] == Place::hidden;
      if (!known && !drawn.hides(grains[i]))
        m_in_sight[c].push_back(grains[i]);
    }
  }
  m_eye_ready = false;
}

void Geometry::attach_grain_data() {
  // Every grain of a cloud is cut alike, so its vertices are a run of the same length.
  std::array<std::vector<std::array<float, 4>>, 2> data; // boxes, rounds
  [[maybe_unused]] const std::array<std::size_t, 2> totals = {m_box_vertices.size(), m_round_triangles.vertices.size()};
  for (const DrawCloud& cloud : m_clouds) {
    if (cloud.grains.empty() || cloud.seen_by == DrawCloud::For::light)
      continue;
    const std::size_t kind = cloud.segments == 0 ? 0 : 1;
    const std::size_t run = kind == 0 ? BOX_VERTICES : round_vertices(cloud.shape, cloud.segments);
    for (const DrawGrain& grain : cloud.grains)
      data[kind].insert(data[kind].end(), run,
                        {grain.velocity[0], grain.velocity[1], grain.velocity[2], static_cast<float>(cloud.body)});
  }
  for (std::size_t kind = 0; kind < 2; ++kind) {
    assert(data[kind].size() == totals[kind]);
    const GlObject& buffer = kind == 0 ? m_box_data : m_round_data;
    const GLuint array = kind == 0 ? m_box_array.name() : m_round_array.name();
    fill(m_gl, buffer, data[kind]);
    m_gl.VertexArrayVertexBuffer(array, 1, buffer.name(), 0, sizeof(std::array<float, 4>));
    m_gl.VertexArrayAttribFormat(array, GRAIN_DATA, 4, GL_FLOAT, GL_FALSE, 0);
    attribute(m_gl, array, GRAIN_DATA, 1);
  }
}

void Geometry::face_light(const Eigen::Vector3f& towards, float seconds) {
  if (m_clouds.empty() || (m_light_ready && seconds == m_light_seconds))
    return;
  m_outline_vertices.clear();
  for (const DrawCloud& cloud : m_clouds) {
    if (cloud.seen_by != DrawCloud::For::eye)
      append_outlines(cloud.grains, {ViewPoint::Kind::direction, towards}, seconds, m_outline_vertices);
  }
  fill(m_gl, m_outlines, m_outline_vertices);
  const std::size_t outlines = m_outline_vertices.size() / OUTLINE_VERTICES;
  grow_pattern(m_outline_indices, outline_indices(), OUTLINE_VERTICES, outlines, m_outline_pattern);
  m_outline_count = static_cast<GLsizei>(outlines * OUTLINE_INDICES);
  m_light_ready = true;
  m_light_seconds = seconds;
}

void Geometry::draw_boxes() const {
  m_gl.BindVertexArray(m_box_array.name());
  m_gl.DrawElements(GL_TRIANGLES, m_box_count, GL_UNSIGNED_INT, nullptr);
}

void Geometry::draw_rounds() const {
  m_gl.BindVertexArray(m_round_array.name());
  m_gl.DrawElements(GL_TRIANGLES, m_round_count, GL_UNSIGNED_INT, nullptr);
}

void Geometry::draw_outlines() const {
  m_gl.BindVertexArray(m_outline_array.name());
  m_gl.DrawElements(GL_TRIANGLES, m_outline_count, GL_UNSIGNED_INT, nullptr);
}

void Geometry::draw_outlines(std::span<const std::uint32_t> chosen) const {
  std::vector<std::uint32_t> indices;
  indices.reserve(chosen.size() * OUTLINE_INDICES);
  for (const std::uint32_t outline : chosen) {
    for (const std::uint32_t index : outline_indices())
      indices.push_back(outline * OUTLINE_VERTICES + index);
  }
  fill(m_gl, m_chosen_indices, indices);
  m_gl.VertexArrayElementBuffer(m_outline_array.name(), m_chosen_indices.name());
  m_gl.BindVertexArray(m_outline_array.name());
  m_gl.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(indices.size()), GL_UNSIGNED_INT, nullptr);
  m_gl.VertexArrayElementBuffer(m_outline_array.name(), m_outline_indices.name());
}

} // namespace wry::render
