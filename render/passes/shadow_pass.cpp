#include "render/passes/pass.h"

namespace wry::render {
namespace {

const char* const VERTEX_SHADER = R"(#version 450 core
layout(location = 0) in vec3 position;
uniform mat4 clip_from_world;
void main() { gl_Position = clip_from_world * vec4(position, 1.0); })";

const char* const FRAGMENT_SHADER = R"(#version 450 core
void main() {})";

/// Depth of the scene as the key light sees it, nearest first.
class ShadowPass final : public Pass {
public:
  ShadowPass(const PassResources& resources, Program program)
      : m_resources(resources)
      , m_program(std::move(program)) {}

  void draw(const SubFrame& sub_frame) override {
    const GlFunctions& gl = m_resources.gl;
    const GLuint frame = m_resources.targets.shadow_frame.name();
    const float farthest = 1.f;
    gl.BindFramebuffer(GL_FRAMEBUFFER, frame);
    gl.Viewport(0, 0, SHADOW_MAP_SIZE, SHADOW_MAP_SIZE);
    gl.ClearNamedFramebufferfv(frame, GL_DEPTH, 0, &farthest);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LESS);
    gl.Disable(GL_BLEND);
    m_program.use();
    m_program.set("clip_from_world", sub_frame.lights.clip_from_world_shadow);
    m_resources.geometry.draw();
  }

private:
  PassResources m_resources;
  Program m_program;
};

} // namespace

Result<std::unique_ptr<Pass>> create_shadow_pass(const PassResources& resources) {
  Result<Program> program = Program::create(resources.gl, "shadow", VERTEX_SHADER, FRAGMENT_SHADER);
  if (!program.ok())
    return program.error();
  return std::unique_ptr<Pass>(std::make_unique<ShadowPass>(resources, std::move(*program)));
}

} // namespace wry::render
