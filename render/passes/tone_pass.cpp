#include "render/passes/pass.h"

#include <cmath>

namespace wry::render {
namespace {

/// A filmic curve in the manner of AgX: colours are drawn together a little (so that bright ones run to white instead
/// of to a pure primary), their logarithm goes through a sigmoid about middle grey, and they are spread again. Middle
/// grey (0.18) stays middle grey (0.46 encoded); the toe reaches 10 stops down, the shoulder 6.5 up. Then half a grey
/// level of noise, the same on every frame, against bands.
const char* const FRAGMENT_SHADER = R"(#version 450 core
uniform sampler2D accumulation;
uniform float exposure;
uniform int filmic;
uniform int straight;
uniform float grain; // one step of the picture's depth
layout(location = 0) out vec4 display;

const float BLACK_STOPS = -10.0;
const float WHITE_STOPS = 6.5;
const float PIVOT_IN = -BLACK_STOPS / (WHITE_STOPS - BLACK_STOPS);
const float PIVOT_OUT = 0.466;
const float SLOPE = 2.45;

// Straight through the pivot, bending towards `limit` with the given power.
vec3 bent(vec3 x, float limit, float power) { return x / pow(1.0 + pow(x / limit, vec3(power)), vec3(1.0 / power)); }

vec3 sigmoid(vec3 x) {
  vec3 up = max(x - PIVOT_IN, 0.0) * SLOPE;
  vec3 down = max(PIVOT_IN - x, 0.0) * SLOPE;
  float up_end = bent(vec3((1.0 - PIVOT_IN) * SLOPE), 1.0 - PIVOT_OUT, 2.6).x;
  float down_end = bent(vec3(PIVOT_IN * SLOPE), PIVOT_OUT, 2.6).x;
  return PIVOT_OUT + bent(up, 1.0 - PIVOT_OUT, 2.6) * ((1.0 - PIVOT_OUT) / up_end) -
         bent(down, PIVOT_OUT, 2.6) * (PIVOT_OUT / down_end);
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
  vec3 encoded = filmic != 0 ? filmic_curve(colour) : srgb_curve(colour);
  vec3 dither = vec3(noise(gl_FragCoord.xy), noise(gl_FragCoord.xy + 47.0), noise(gl_FragCoord.xy + 89.0)) - 0.5;
  display = vec4(encoded + dither * grain, light.a);
})";

class TonePass final : public Pass {
public:
  TonePass(const PassResources& resources, Program program)
      : m_resources(resources)
      , m_program(std::move(program)) {}

  void draw(const SubFrame& sub_frame) override {
    const GlFunctions& gl = m_resources.gl;
    const Targets& targets = m_resources.targets;
    gl.BindFramebuffer(GL_FRAMEBUFFER, targets.display_frame.name());
    gl.Viewport(0, 0, targets.size.width, targets.size.height);
    gl.Disable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    gl.BindTextureUnit(0, targets.accumulation.name());
    m_program.use();
    m_program.set("accumulation", 0);
    const bool filmic = sub_frame.view->tone == Tone::filmic && m_resources.plan.tone == Tone::filmic;
    m_program.set("exposure", sub_frame.view->tone == Tone::filmic
                                  ? static_cast<float>(std::exp2(m_resources.plan.exposure_stops))
                                  : 1.f);
    m_program.set("filmic", filmic ? 1 : 0);
    m_program.set("straight", m_resources.plan.background == Background::clear ? 1 : 0);
    m_program.set("grain", m_resources.plan.bits == 16 ? 1.f / 65535.f : 1.f / 255.f);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
  }

private:
  PassResources m_resources;
  Program m_program;
};

} // namespace

Result<std::unique_ptr<Pass>> create_tone_pass(const PassResources& resources) {
  Result<Program> program = Program::create(resources.gl, "tone", FULL_SCREEN_VERTEX_SHADER, FRAGMENT_SHADER);
  if (!program.ok())
    return program.error();
  return std::unique_ptr<Pass>(std::make_unique<TonePass>(resources, std::move(*program)));
}

} // namespace wry::render
