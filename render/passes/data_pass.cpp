#include "render/passes/data_pass.h"

#include <array>

namespace wry::render {
namespace {

const char* const TRIANGLE_VERTEX = R"(#version 450 core
layout(location = 0) in vec3 position;
layout(location = 2) in uint look;
layout(location = 5) in vec3 velocity;
uniform mat4 clip_from_world;
out vec3 speed;
flat out float body;
void main() {
  gl_Position = clip_from_world * vec4(position, 1.0);
  speed = velocity;
  body = float(look >> 8);
})";

const char* const GRAIN_VERTEX = R"(#version 450 core
layout(location = 0) in vec3 position;
layout(location = 7) in vec4 data;
uniform mat4 clip_from_world;
out vec3 speed;
flat out float body;
void main() {
  gl_Position = clip_from_world * vec4(position, 1.0);
  speed = data.xyz;
  body = data.w;
})";

const char* const FRAGMENT = R"(#version 450 core
in vec3 speed;
flat in float body;
layout(location = 0) out vec4 data;
void main() { data = vec4(speed, body); })";

} // namespace

Result<std::unique_ptr<DataPass>> DataPass::create(const PassResources& resources) {
  const GlFunctions& gl = resources.gl;
  Result<Program> triangles = Program::create(gl, "data", TRIANGLE_VERTEX, FRAGMENT);
  if (!triangles.ok())
    return triangles.error();
  Result<Program> grains = Program::create(gl, "grain data", GRAIN_VERTEX, FRAGMENT);
  if (!grains.ok())
    return grains.error();
  std::unique_ptr<DataPass> pass(new DataPass(resources, std::move(*triangles), std::move(*grains)));
  const ImageSize& size = resources.targets.size;
  pass->m_data = make_texture(gl, GL_RGBA32F, size.width, size.height, TextureFilter::nearest);
  pass->m_depth = make_texture(gl, GL_DEPTH_COMPONENT32F, size.width, size.height, TextureFilter::nearest);
  if (gl.GetError() != GL_NO_ERROR)
    return make_error(ErrorCode::out_of_memory, "no memory for the data layers of {} x {} pixels", size.width,
                      size.height);
  Result<GlObject> frame = make_framebuffer(gl, pass->m_data.name(), pass->m_depth.name());
  if (!frame.ok())
    return frame.error();
  pass->m_frame = std::move(*frame);
  return pass;
}

void DataPass::draw(const SubFrame& sub_frame) {
  const GlFunctions& gl = m_resources.gl;
  const std::array<float, 4> nothing = {0.f, 0.f, 0.f, 0.f};
  const float farthest = 0.f;
  gl.BindFramebuffer(GL_FRAMEBUFFER, m_frame.name());
  gl.Viewport(0, 0, m_resources.targets.size.width, m_resources.targets.size.height);
  gl.ClearNamedFramebufferfv(m_frame.name(), GL_COLOR, 0, nothing.data());
  gl.ClearNamedFramebufferfv(m_frame.name(), GL_DEPTH, 0, &farthest);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_GREATER);
  gl.Disable(GL_BLEND);
  m_triangles.use();
  m_triangles.set("clip_from_world", sub_frame.clip_from_world);
  m_resources.geometry.draw();
  if (!m_resources.geometry.has_clouds())
    return;
  m_grains.use();
  m_grains.set("clip_from_world", sub_frame.clip_from_world);
  m_resources.geometry.draw_boxes();
  m_resources.geometry.draw_rounds();
}

} // namespace wry::render
