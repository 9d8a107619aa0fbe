#include "render/passes/pass.h"

#include <array>

namespace wry::render {
namespace {

const char* const VERTEX_SHADER = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in uint look;
layout(location = 3) in float value;
layout(location = 4) in vec4 tint;
layout(location = 5) in vec3 velocity;
layout(location = 6) in vec2 uv;
uniform mat4 clip_from_world;
uniform float seconds;
out vec3 corner_normal;
flat out uint surface_look;
#ifdef TINTED
out vec3 corner_tint;
#else
out float corner_value;
#endif
#ifdef TEXTURED
out vec2 corner_uv;
#endif
#ifdef WIRE
noperspective out vec3 corner_weights;
#endif
void main() {
  gl_Position = clip_from_world * vec4(position + velocity * seconds, 1.0);
  corner_normal = normal;
  surface_look = (look & 255u) + 1u;
#ifdef TINTED
  corner_tint = tint.rgb;
#else
  corner_value = value;
#endif
#ifdef TEXTURED
  corner_uv = uv;
#endif
#ifdef WIRE
  int corner = gl_VertexID % 3;
  corner_weights = vec3(corner == 0, corner == 1, corner == 2);
#endif
})";

/// Unit vectors on the octahedron (Meyer et al. 2010), two times 16 bits.
const char* const OCTAHEDRAL = R"(
layout(location = 0) out uvec2 surface;
vec2 octahedral(vec3 n) {
  n /= max(abs(n.x) + abs(n.y) + abs(n.z), 1e-20);
  vec2 folded = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
  return n.z >= 0.0 ? n.xy : folded;
}
)";

const char* const FRAGMENT_SHADER = R"(
in vec3 corner_normal;
flat in uint surface_look;
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
#ifdef TEXTURED
in vec2 corner_uv;
uniform sampler2D picture;
vec4 painted() { return texture(picture, corner_uv); }
#else
vec4 painted() { return vec4(1.0); }
#endif
#ifdef TINTED
in vec3 corner_tint;
uint payload() {
  vec4 paint = painted();
#ifdef TEXTURED
  if (paint.a < 0.5)
    discard;
#endif
  uvec3 bytes = uvec3(clamp(corner_tint * sqrt(paint.rgb), 0.0, 1.0) * 255.0 + 0.5);
  return (bytes.r << 16) | (bytes.g << 8) | bytes.b;
}
#else
in float corner_value;
uint payload() {
  uint heat = corner_value < -1.5 ? 65535u : corner_value < -0.5 ? 65534u
                                           : uint(clamp(corner_value, 0.0, 1.0) * 65533.0 + 0.5);
  return (uint(wire() * 255.0 + 0.5) << 16) | heat;
}
#endif
void main() {
  vec3 n = gl_FrontFacing ? corner_normal : -corner_normal;
  surface.x = (surface_look << 24) | payload();
  surface.y = packSnorm2x16(octahedral(n));
})";

const char* const GRAIN_VERTEX_SHADER = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in uint normal;
layout(location = 2) in uint word;
uniform mat4 clip_from_world;
flat out uint grain_word;
#ifdef ROUND
out vec3 corner_normal;
vec3 from_octahedral(vec2 e) {
  vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
  float fold = max(-n.z, 0.0);
  n.xy += vec2(n.x >= 0.0 ? -fold : fold, n.y >= 0.0 ? -fold : fold);
  return normalize(n);
}
#else
flat out uint grain_normal;
#endif
void main() {
  gl_Position = clip_from_world * vec4(position, 1.0);
  grain_word = word;
#ifdef ROUND
  corner_normal = from_octahedral(unpackSnorm2x16(normal));
#else
  grain_normal = normal;
#endif
})";

const char* const GRAIN_FRAGMENT_SHADER = R"(
flat in uint grain_word;
#ifdef ROUND
in vec3 corner_normal;
void main() { surface = uvec2(grain_word, packSnorm2x16(octahedral(corner_normal))); }
#else
flat in uint grain_normal;
void main() { surface = uvec2(grain_word, grain_normal); }
#endif
)";

std::string complete(const std::string& defines, const std::string& source) {
  return "#version 450 core\n" + defines + source;
}

/// Triangles and grains, each in the ways that they are drawn.
struct SurfacePrograms {
  Program tinted;
  Program textured;
  Program plain;
  Program wire;
  Program boxes;
  Program rounds;
};

/// What is seen in each pixel: look, normal, heat and wire. Shading comes later, once per pixel.
class SurfacePass final : public Pass {
public:
  SurfacePass(const PassResources& resources, SurfacePrograms programs)
      : m_resources(resources)
      , m_programs(std::move(programs)) {}

  void draw(const SubFrame& sub_frame) override {
    const GlFunctions& gl = m_resources.gl;
    const Targets& targets = m_resources.targets;
    const GLuint frame = targets.surface_frame.name();
    const std::array<GLuint, 4> nothing = {0, 0, 0, 0};
    const float farthest = 0.f;
    gl.BindFramebuffer(GL_FRAMEBUFFER, frame);
    gl.Viewport(0, 0, targets.size.width, targets.size.height);
    if (!sub_frame.surface_begun) {
      gl.ClearNamedFramebufferuiv(frame, GL_COLOR, 0, nothing.data());
      gl.ClearNamedFramebufferfv(frame, GL_DEPTH, 0, &farthest);
    }
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_GREATER);
    gl.Disable(GL_BLEND);
    if (!sub_frame.surface_begun)
      draw_triangles(sub_frame);
    draw_grains(sub_frame);
  }

private:
  void begin(const Program& program, const SubFrame& sub_frame) const {
    program.use();
    program.set("clip_from_world", sub_frame.clip_from_world);
    program.set("seconds", sub_frame.seconds);
    program.set("wire_width", std::max(1.f, static_cast<float>(m_resources.targets.size.height) / 900.f));
  }

  void draw_triangles(const SubFrame& sub_frame) const {
    const Geometry& geometry = m_resources.geometry;
    if (!geometry.has_triangles())
      return;
    if (sub_frame.view->colouring != Colouring::look) {
      begin(sub_frame.view->wire == Wire::overlay ? m_programs.wire : m_programs.plain, sub_frame);
      geometry.draw();
    } else if (!geometry.is_textured()) {
      begin(m_programs.tinted, sub_frame);
      geometry.draw();
    } else {
      geometry.draw_textured([&](GLuint texture) {
        const Program& program = texture != 0 ? m_programs.textured : m_programs.tinted;
        begin(program, sub_frame);
        program.set("picture", 0);
        m_resources.gl.BindTextureUnit(0, texture);
      });
    }
  }

  void draw_grains(const SubFrame& sub_frame) const {
    if (!m_resources.geometry.has_clouds())
      return;
    begin(m_programs.boxes, sub_frame);
    m_resources.geometry.draw_boxes();
    begin(m_programs.rounds, sub_frame);
    m_resources.geometry.draw_rounds();
  }

  PassResources m_resources;
  SurfacePrograms m_programs;
};

} // namespace

Result<std::unique_ptr<Pass>> create_surface_pass(const PassResources& resources) {
  SurfacePrograms programs;
  const std::string surface = std::string(OCTAHEDRAL) + FRAGMENT_SHADER;
  const std::string grain = std::string(OCTAHEDRAL) + GRAIN_FRAGMENT_SHADER;
  struct Variant {
    Program* program;
    const char* what;
    const char* defines;
    const char* vertex;
    const std::string& fragment;
  };
  for (const Variant& variant :
       {Variant{&programs.tinted, "surface", "#define TINTED\n", VERTEX_SHADER, surface},
        Variant{&programs.textured, "textured surface", "#define TINTED\n#define TEXTURED\n", VERTEX_SHADER, surface},
        Variant{&programs.plain, "plain surface", "", VERTEX_SHADER, surface},
        Variant{&programs.wire, "wire surface", "#define WIRE\n", VERTEX_SHADER, surface},
        Variant{&programs.boxes, "box grains", "", GRAIN_VERTEX_SHADER, grain},
        Variant{&programs.rounds, "round grains", "#define ROUND\n", GRAIN_VERTEX_SHADER, grain}}) {
    Result<Program> made = Program::create(resources.gl, variant.what, complete(variant.defines, variant.vertex),
                                           complete(variant.defines, variant.fragment));
    if (!made.ok())
      return made.error();
    *variant.program = std::move(*made);
  }
  return std::unique_ptr<Pass>(std::make_unique<SurfacePass>(resources, std::move(programs)));
}

} // namespace wry::render
