#include "render/passes/pass.h"

#include <cmath>

namespace wry::render {
namespace {

/// A filmic curve in the manner of AgX: colours are drawn together a little (so that bright ones run to white instead
/// of to a pure primary), their logarithm goes through a sigmoid about middle grey, and they are spread again. Middle
/// grey (0.18) stays middle grey (0.46 encoded); the toe reaches 10 stops down, the shoulder 6.5 up. Then half a grey
/// level of noise, the same on every frame, against bands.
const char* const FRAGMENT_SHADER = R"(
uniform sampler2D accumulation;
uniform float exposure;
uniform int straight;
uniform float grain; // one step of the picture's depth
layout(location = 0) out vec4 display;

const float BLACK_STOPS = -10.0;
const float WHITE_STOPS = 6.5;
const float PIVOT_IN = -BLACK_STOPS / (WHITE_STOPS - BLACK_STOPS);
const float PIVOT_OUT = 0.466;
const float SLOPE = 2.45;

// (1 + t^2.6)^(-1/2.6), which bends a straight line towards 1, as a quotient of polynomials: within 2e-5 up to t = 3.25,
// at a fifth of the cost.
vec3 bend(vec3 t) {
  vec3 over = 1.0 + t * (0.61992766 + t * (0.84419013 + t * 0.43819143));
  return over / (1.0 + t * (0.61367930 + t * (0.96093589 + t * (0.76924817 + t * 0.44517389))));
}

// Straight through the pivot, bending towards black and white.
vec3 sigmoid(vec3 x) {
  const vec2 LIMITS = vec2(PIVOT_OUT, 1.0 - PIVOT_OUT);
  const vec2 ENDS = vec2(PIVOT_IN, 1.0 - PIVOT_IN) * SLOPE / LIMITS;
  vec2 gains = 1.0 / (ENDS * bend(vec3(ENDS, 0.0)).xy); // the ends arrive at black and white
  vec3 away = (x - PIVOT_IN) * SLOPE;
  bvec3 up = greaterThan(away, vec3(0.0));
  vec3 t = abs(away) / mix(vec3(LIMITS.x), vec3(LIMITS.y), up);
  return PIVOT_OUT + t * bend(t) * mix(vec3(-LIMITS.x * gains.x), vec3(LIMITS.y * gains.y), up);
}

vec3 filmic_curve(vec3 c) {
  const float INSET = 0.07;
  float mean = (c.r + c.g + c.b) / 3.0;
  c = mix(c, vec3(mean), INSET);
  vec3 stops = log2(max(c, vec3(1e-9)) / 0.18);
  vec3 encoded = sigmoid(clamp((stops - BLACK_STOPS) / (WHITE_STOPS - BLACK_STOPS), 0.0, 1.0));
  mean = (encoded.r + encoded.g + encoded.b) / 3.0;
  return clamp(mix(vec3(mean), encoded, 1.0 / (1.0 - INSET) * 1.06), 0.0, 1.0);
}

vec3 srgb_curve(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308)));
}

// Interleaved gradient noise (Jimenez 2014).
float noise(vec2 p) { return fract(52.9829189 * fract(dot(p, vec2(0.06711056, 0.00583715)))); }

void main() {
  vec4 light = texelFetch(accumulation, ivec2(gl_FragCoord.xy), 0);
  float cover = straight != 0 && light.a > 0.0 ? 1.0 / light.a : 1.0; // straight alpha: the colour without its share
  vec3 colour = max(light.rgb, 0.0) * exposure * cover;
#ifdef FILMIC
  vec3 encoded = filmic_curve(colour);
#else
  vec3 encoded = srgb_curve(colour);
#endif
  vec3 dither = vec3(noise(gl_FragCoord.xy), noise(gl_FragCoord.xy + 47.0), noise(gl_FragCoord.xy + 89.0)) - 0.5;
  display = vec4(encoded + dither * grain, light.a);
})";

class TonePass final : public Pass {
public:
  TonePass(const PassResources& resources, Program filmic, Program plain)
      : m_resources(resources)
      , m_filmic(std::move(filmic))
      , m_plain(std::move(plain)) {}

  void draw(const SubFrame& sub_frame) override {
    const GlFunctions& gl = m_resources.gl;
    const Targets& targets = m_resources.targets;
    gl.BindFramebuffer(GL_FRAMEBUFFER, targets.display_frame.name());
    gl.Viewport(0, 0, targets.size.width, targets.size.height);
    gl.Disable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    gl.BindTextureUnit(0, targets.accumulation.name());
    const bool filmic = sub_frame.view->tone == Tone::filmic && m_resources.plan.tone == Tone::filmic;
    const Program& program = filmic ? m_filmic : m_plain;
    program.use();
    program.set("accumulation", 0);
    program.set("exposure", sub_frame.view->tone == Tone::filmic
                                ? static_cast<float>(std::exp2(m_resources.plan.exposure_stops))
                                : 1.f);
    program.set("straight", m_resources.plan.background == Background::clear ? 1 : 0);
    program.set("grain", m_resources.plan.bits == 16 ? 1.f / 65535.f : 1.f / 255.f);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
  }

private:
  PassResources m_resources;
  Program m_filmic;
  Program m_plain;
};

} // namespace

Result<std::unique_ptr<Pass>> create_tone_pass(const PassResources& resources) {
  const std::string begin = "#version 450 core\n";
  Result<Program> filmic = Program::create(resources.gl, "filmic tone", FULL_SCREEN_VERTEX_SHADER,
                                           begin + "#define FILMIC\n" + FRAGMENT_SHADER);
  if (!filmic.ok())
    return filmic.error();
  Result<Program> plain = Program::create(resources.gl, "tone", FULL_SCREEN_VERTEX_SHADER, begin + FRAGMENT_SHADER);
  if (!plain.ok())
    return plain.error();
  return std::unique_ptr<Pass>(std::make_unique<TonePass>(resources, std::move(*filmic), std::move(*plain)));
}

} // namespace wry::render
