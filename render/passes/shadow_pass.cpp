#include "render/passes/pass.h"

namespace wry::render {
namespace {

const char* const VERTEX_SHADER = R"(#version 450 core
layout(location = 0) in vec3 position;
layout(location = 5) in vec3 velocity; // grains come already moved: theirs reads as zero
uniform mat4 clip_from_world;
uniform float seconds;
void main() { gl_Position = clip_from_world * vec4(position + velocity * seconds, 1.0); })";

const char* const FRAGMENT_SHADER = R"(#ifdef CLEAR
// A transparent body lets most of the light pass: one texel of four stops it, which the filter makes even.
void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  if (((texel.x & 1) | (texel.y & 1)) != 0)
    discard;
}
#else
void main() {}
#endif
)";

/// Depth of the scene as the key light sees it, nearest first.
class ShadowPass final : public Pass {
public:
  ShadowPass(const PassResources& resources, Program program, Program clear)
      : m_resources(resources)
      , m_program(std::move(program))
      , m_clear(std::move(clear)) {}

  void draw(const SubFrame& sub_frame) override {
    if (sub_frame.index % sub_frame.lights.frames_per_map != 0)
      return;
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
    m_program.set("seconds", sub_frame.seconds);
    m_resources.geometry.draw();
    if (m_resources.geometry.has_clouds())
      draw_outlines(sub_frame.lights);
    if (!m_resources.geometry.has_clear())
      return;
    m_clear.use();
    m_clear.set("clip_from_world", sub_frame.lights.clip_from_world_shadow);
    m_clear.set("seconds", sub_frame.seconds);
    m_resources.geometry.draw_clear();
  }

private:
  /// Most grains of a heap are in the shadow of others: they need not be drawn.
  void draw_outlines(const LightState& lights) {
    constexpr std::size_t WORTH_IT = 20000;
    const Geometry& geometry = m_resources.geometry;
    if (geometry.outlines().size() < WORTH_IT * OUTLINE_VERTICES) {
      geometry.draw_outlines();
      return;
    }
    OutlineOrder order(geometry.outlines(), lights.clip_from_world_shadow, SHADOW_MAP_SIZE);
    geometry.draw_outlines(order.first_met(FIRST_MET));
    std::vector<float> depth(static_cast<std::size_t>(SHADOW_MAP_SIZE) * SHADOW_MAP_SIZE);
    m_resources.gl.GetTextureImage(m_resources.targets.shadow.name(), 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                                   static_cast<GLsizei>(depth.size() * sizeof(float)), depth.data());
    geometry.draw_outlines(order.seen_of_the_rest(std::move(depth)));
  }

  PassResources m_resources;
  Program m_program;
  Program m_clear;
};

} // namespace

Result<std::unique_ptr<Pass>> create_shadow_pass(const PassResources& resources) {
  const std::string begin = "#version 450 core\n";
  Result<Program> program = Program::create(resources.gl, "shadow", VERTEX_SHADER, begin + FRAGMENT_SHADER);
  if (!program.ok())
    return program.error();
  Result<Program> clear =
      Program::create(resources.gl, "clear shadow", VERTEX_SHADER, begin + "#define CLEAR\n" + FRAGMENT_SHADER);
  if (!clear.ok())
    return clear.error();
  return std::unique_ptr<Pass>(std::make_unique<ShadowPass>(resources, std::move(*program), std::move(*clear)));
}

} // namespace wry::render
