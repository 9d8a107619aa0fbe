#include "render/passes/pass.h"

#include <array>

namespace wry::render {
namespace {

const char* const VERTEX_SHADER = R"(#version 450 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint look;
layout(location = 3) in float value;
uniform mat4 clip_from_world;
out vec3 corner_normal;
out float corner_value;
flat out uint surface_look;
#ifdef WIRE
noperspective out vec3 corner_weights;
#endif
void main() {
  gl_Position = clip_from_world * vec4(position, 1.0);
  corner_normal = normal;
  corner_value = value;
  surface_look = look + 1u;
#ifdef WIRE
  int corner = gl_VertexID % 3;
  corner_weights = vec3(corner == 0, corner == 1, corner == 2);
#endif
})";

const char* const FRAGMENT_SHADER = R"(#version 450 core
in vec3 corner_normal;
in float corner_value;
flat in uint surface_look;
layout(location = 0) out uvec2 surface;
#ifdef WIRE
noperspective in vec3 corner_weights;
uniform float wire_width;
// Share of the pixel that lies on an edge; triangles of a few pixels keep their shade instead of turning black.
float wire() {
  vec3 per_pixel = vec3(length(vec2(dFdx(corner_weights.x), dFdy(corner_weights.x))),
                        length(vec2(dFdx(corner_weights.y), dFdy(corner_weights.y))),
                        length(vec2(dFdx(corner_weights.z), dFdy(corner_weights.z))));
  vec3 pixels = corner_weights / max(per_pixel, vec3(1e-9));
  float nearest = min(pixels.x, min(pixels.y, pixels.z));
  float height = 1.0 / max(per_pixel.x, max(per_pixel.y, per_pixel.z));
  return clamp(0.5 * wire_width + 0.5 - nearest, 0.0, 1.0) * smoothstep(1.5, 7.0, height);
}
#else
float wire() { return 0.0; }
#endif
// Unit vectors on the octahedron (Meyer et al. 2010), two times 16 bits.
vec2 octahedral(vec3 n) {
  n /= max(abs(n.x) + abs(n.y) + abs(n.z), 1e-20);
  vec2 folded = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
  return n.z >= 0.0 ? n.xy : folded;
}
uint heat() {
  if (corner_value < -1.5) return 65535u;
  if (corner_value < -0.5) return 65534u;
  return uint(clamp(corner_value, 0.0, 1.0) * 65533.0 + 0.5);
}
void main() {
  vec3 n = gl_FrontFacing ? corner_normal : -corner_normal;
  surface.x = (surface_look << 24) | (uint(wire() * 255.0 + 0.5) << 16) | heat();
  surface.y = packSnorm2x16(octahedral(n));
})";

std::string with_wire(const std::string& source) {
  std::string changed = source;
  return changed.insert(changed.find('\n') + 1, "#define WIRE\n");
}

/// What is seen in each pixel: look, normal, heat and wire. Shading comes later, once per pixel.
class SurfacePass final : public Pass {
public:
  SurfacePass(const PassResources& resources, Program plain, Program wire)
      : m_resources(resources)
      , m_plain(std::move(plain))
      , m_wire(std::move(wire)) {}

  void draw(const SubFrame& sub_frame) override {
    const GlFunctions& gl = m_resources.gl;
    const Targets& targets = m_resources.targets;
    const GLuint frame = targets.surface_frame.name();
    const std::array<GLuint, 4> nothing = {0, 0, 0, 0};
    const float farthest = 0.f;
    gl.BindFramebuffer(GL_FRAMEBUFFER, frame);
    gl.Viewport(0, 0, targets.size.width, targets.size.height);
    gl.ClearNamedFramebufferuiv(frame, GL_COLOR, 0, nothing.data());
    gl.ClearNamedFramebufferfv(frame, GL_DEPTH, 0, &farthest);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_GREATER);
    gl.Disable(GL_BLEND);
    const Program& program = sub_frame.view->wire == Wire::overlay ? m_wire : m_plain;
    program.use();
    program.set("clip_from_world", sub_frame.clip_from_world);
    program.set("wire_width", std::max(1.f, static_cast<float>(targets.size.height) / 900.f));
    m_resources.geometry.draw();
  }

private:
  PassResources m_resources;
  Program m_plain;
  Program m_wire;
};

} // namespace

Result<std::unique_ptr<Pass>> create_surface_pass(const PassResources& resources) {
  Result<Program> plain = Program::create(resources.gl, "surface", VERTEX_SHADER, FRAGMENT_SHADER);
  if (!plain.ok())
    return plain.error();
  Result<Program> wire =
      Program::create(resources.gl, "wire surface", with_wire(VERTEX_SHADER), with_wire(FRAGMENT_SHADER));
  if (!wire.ok())
    return wire.error();
  return std::unique_ptr<Pass>(std::make_unique<SurfacePass>(resources, std::move(*plain), std::move(*wire)));
}

} // namespace wry::render
