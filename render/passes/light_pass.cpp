#include "render/passes/pass.h"

#include <optional>
#include <tuple>

#include "render/brdf_table.h"
#include "render/color_map.h"
#include "render/environment.h"
#include "render/passes/light_shader.h"
#include "render/passes/shader_parts.h"

namespace wry::render {
namespace {

/// Looks as the shader's tables.
struct LookRows {
  Eigen::Matrix4Xf base;
  Eigen::Matrix4Xf layers;
  Eigen::Matrix4Xf scatter;
  Eigen::Matrix4Xf clear;
};

LookRows look_rows(const std::vector<Look>& looks) {
  const Eigen::Index count = static_cast<Eigen::Index>(looks.size());
  LookRows rows{Eigen::Matrix4Xf(4, count), Eigen::Matrix4Xf(4, count), Eigen::Matrix4Xf(4, count),
                Eigen::Matrix4Xf(4, count)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const Look& look = looks[static_cast<std::size_t>(i)];
    rows.base.col(i) << look.base_colour, look.roughness;
    rows.layers.col(i) << look.metallic, look.specular, look.clearcoat, look.clearcoat_roughness;
    rows.scatter.col(i) << look.scatter, look.wrap;
    rows.clear.col(i) << look.transparency, 0.f, 0.f, 0.f;
  }
  return rows;
}

Eigen::Matrix4Xf heat_columns() {
  Eigen::Matrix4Xf columns(4, static_cast<Eigen::Index>(heat_colours().size()));
  for (std::size_t i = 0; i < heat_colours().size(); ++i) {
    const DisplayColour& colour = heat_colours()[i];
    columns.col(static_cast<Eigen::Index>(i)) << colour[0], colour[1], colour[2], 1.f;
  }
  return columns;
}

constexpr GLuint MIRRORED_UNIT = 5;

const char* const SUM_SHADER = R"(#version 450 core
uniform sampler2D finished;
uniform float weight;
layout(location = 0) out vec4 light;
void main() { light = texelFetch(finished, ivec2(gl_FragCoord.xy), 0) * weight; })";

/// The four rectangles about a rectangle.
std::vector<PixelRect> around(const PixelRect& inner, const ImageSize& size) {
  const int right = inner.x + inner.width;
  const int top = inner.y + inner.height;
  return {{0, 0, size.width, inner.y},
          {0, top, size.width, size.height - top},
          {0, inner.y, inner.x, inner.height},
          {right, inner.y, size.width - right, inner.height}};
}

/// The programs of the light pass: floor and backdrop are far cheaper than the subject.
struct LightPrograms {
  Program touched;
  Program open;
  Program subject;
  Program clay;
  Program heat;
  Program clear; ///< transparent bodies
  Program sum;   ///< adds a finished sub-frame
};

/// Shades every pixel once.
class LightPass final : public Pass {
public:
  LightPass(const PassResources& resources, LightPrograms programs)
      : m_resources(resources)
      , m_programs(std::move(programs))
      , m_looks(look_rows(resources.looks))
      , m_brdf(make_texture(resources.gl, GL_RG32F, BRDF_TABLE_SIZE, BRDF_TABLE_SIZE, TextureFilter::linear)) {
    const auto table = make_brdf_table();
    resources.gl.TextureSubImage2D(m_brdf.name(), 0, 0, 0, BRDF_TABLE_SIZE, BRDF_TABLE_SIZE, GL_RG, GL_FLOAT,
                                   table.data());
    if (resources.plan.rig.surroundings)
      take_surroundings(light_state(resources.plan, 0.0, 0, 1));
  }

  void draw(const SubFrame& sub_frame) override {
    const GlFunctions& gl = m_resources.gl;
    const Targets& targets = m_resources.targets;
    // Transparent bodies blend with what is behind them, so their sub-frames are finished before they are added.
    const bool sees_through = m_resources.geometry.has_clear();
    const GLuint frame = sees_through ? targets.light_frame.name() : targets.accumulation_frame.name();
    gl.BindFramebuffer(GL_FRAMEBUFFER, frame);
    gl.Viewport(0, 0, targets.size.width, targets.size.height);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthMask(GL_FALSE);
    if (sub_frame.index == 0 || sees_through) {
      gl.Disable(GL_BLEND);
    } else {
      gl.Enable(GL_BLEND);
      gl.BlendFunc(GL_ONE, GL_ONE);
    }
    const PixelRect& touched = sub_frame.touched;
    // The triangle lies at the far plane: what has no depth is surround, what is nearer is subject.
    gl.DepthFunc(GL_EQUAL);
    draw_with(m_programs.touched, sub_frame, {touched});
    draw_with(m_programs.open, sub_frame, around(touched, targets.size));
    gl.DepthFunc(GL_LESS);
    const Colouring colouring = sub_frame.view->colouring;
    draw_with(colouring == Colouring::heat   ? m_programs.heat
              : colouring == Colouring::look ? m_programs.subject
                                             : m_programs.clay,
              sub_frame, {touched});
    if (sees_through) {
      draw_clear(sub_frame);
      add_sub_frame(sub_frame);
    }
    gl.Disable(GL_BLEND);
    gl.DepthMask(GL_TRUE);
  }

private:
  /// Far walls before near ones.
  void draw_clear(const SubFrame& sub_frame) {
    const GlFunctions& gl = m_resources.gl;
    m_programs.clear.use();
    bind_textures(m_programs.clear);
    set_frame(m_programs.clear, sub_frame);
    set_lights(m_programs.clear, sub_frame);
    set_looks(m_programs.clear);
    m_programs.clear.set("clip_from_world", sub_frame.clip_from_world);
    m_programs.clear.set("seconds", sub_frame.seconds);
    gl.DepthFunc(GL_GREATER);
    gl.Enable(GL_BLEND);
    gl.BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    gl.Enable(GL_CULL_FACE);
    for (const GLenum hidden : {GL_FRONT, GL_BACK}) {
      gl.CullFace(hidden);
      m_resources.geometry.draw_clear();
    }
    gl.Disable(GL_CULL_FACE);
  }

  void add_sub_frame(const SubFrame& sub_frame) {
    const GlFunctions& gl = m_resources.gl;
    const Targets& targets = m_resources.targets;
    gl.BindFramebuffer(GL_FRAMEBUFFER, targets.accumulation_frame.name());
    gl.Disable(GL_DEPTH_TEST);
    if (sub_frame.index == 0)
      gl.Disable(GL_BLEND);
    else
      gl.BlendFunc(GL_ONE, GL_ONE);
    m_programs.sum.use();
    gl.BindTextureUnit(0, targets.light.name());
    m_programs.sum.set("finished", 0);
    m_programs.sum.set("weight", 1.f / static_cast<float>(sub_frame.count));
    draw_in_rect(gl, {0, 0, targets.size.width, targets.size.height});
  }

  void take_surroundings(const LightState& lights) {
    const GlFunctions& gl = m_resources.gl;
    std::optional<Eigen::Vector3f> below;
    if (m_resources.plan.ground.kind != Ground::Kind::none)
      below = lights.bounce / lights.gain;
    EnvironmentMaps maps = make_environment_maps(*m_resources.plan.rig.surroundings, below);
    m_matt.resize(4, 9);
    for (std::size_t i = 0; i < maps.matt.size(); ++i)
      m_matt.col(static_cast<Eigen::Index>(i)) << lights.gain * maps.matt[i], 0.f;
    for (std::array<float, 4>& pixel : maps.mirrored) {
      for (float& value : pixel)
        value *= lights.gain;
    }
    m_mirrored = make_texture(gl, GL_RGBA32F, MIRROR_WIDTH, MIRROR_HEIGHT * MIRROR_LEVELS, TextureFilter::linear);
    gl.TextureParameteri(m_mirrored.name(), GL_TEXTURE_WRAP_S, GL_REPEAT);
    gl.TextureSubImage2D(m_mirrored.name(), 0, 0, 0, MIRROR_WIDTH, MIRROR_HEIGHT * MIRROR_LEVELS, GL_RGBA, GL_FLOAT,
                         maps.mirrored.data());
  }

  void draw_with(const Program& program, const SubFrame& sub_frame, const std::vector<PixelRect>& rects) {
    program.use();
    bind_textures(program);
    set_frame(program, sub_frame);
    set_lights(program, sub_frame);
    set_looks(program);
    for (const PixelRect& rect : rects)
      draw_in_rect(m_resources.gl, rect);
  }

  void bind_textures(const Program& program) {
    const Targets& targets = m_resources.targets;
    const std::array<std::pair<const char*, GLuint>, 5> textures = {{{"surface_map", targets.surface.name()},
                                                                     {"depth_map", targets.depth.name()},
                                                                     {"brdf_map", m_brdf.name()},
                                                                     {"shadow_map", targets.shadow.name()},
                                                                     {"occlusion_map", targets.occlusion.name()}}};
    for (std::size_t unit = 0; unit < textures.size(); ++unit) {
      m_resources.gl.BindTextureUnit(static_cast<GLuint>(unit), textures[unit].second);
      program.set(textures[unit].first, static_cast<int>(unit));
    }
  }

  void set_frame(const Program& program, const SubFrame& sub_frame) {
    set_camera_part(program, sub_frame, m_resources.plan, m_resources.targets.size);
    const bool sees_through = m_resources.geometry.has_clear();
    program.set("weight", sees_through ? 1.f : 1.f / static_cast<float>(sub_frame.count));
    program.set("noise_turn", static_cast<float>(sub_frame.index) * 0.618034f);
    program.set("ground_colour", m_resources.plan.ground.colour);
    program.set("catch_shadow", m_resources.plan.ground.kind == Ground::Kind::catch_shadow ? 1 : 0);
    program.set("show_around", m_resources.plan.rig.backdrop == Rig::Backdrop::surroundings ? 1 : 0);
  }

  void set_lights(const Program& program, const SubFrame& sub_frame) {
    const LightState& lights = sub_frame.lights;
    program.set("floor_key", lights.floor_key);
    program.set("floor_others", lights.floor_others);
    program.set_array("light_directions", lights.directions);
    program.set_array("light_radiances", lights.radiances);
    program.set("sky", lights.sky);
    if (m_resources.plan.rig.surroundings) {
      program.set_array("matt_harmonics", m_matt);
      program.set("around_x", Eigen::Vector3f(lights.around.col(0)));
      program.set("around_y", Eigen::Vector3f(lights.around.col(1)));
      program.set("around_z", Eigen::Vector3f(lights.around.col(2)));
      program.set("backdrop_level", 0.f);
      m_resources.gl.BindTextureUnit(MIRRORED_UNIT, m_mirrored.name());
      program.set("mirrored_map", static_cast<int>(MIRRORED_UNIT));
    }
    program.set("bounce", lights.bounce);
    program.set("backdrop", lights.backdrop);
    set_shadow_space_part(program, lights);
    program.set("shadow_share", lights.shadow_share);
    program.set("occlusion_share", m_resources.plan.rig.occlusion == Rig::Occlusion::near_by ? 1.f : 0.f);
  }

  void set_looks(const Program& program) {
    program.set_array("look_base", m_looks.base);
    program.set_array("look_layers", m_looks.layers);
    program.set_array("look_scatter", m_looks.scatter);
    program.set_array("look_clear", m_looks.clear);
    program.set_array("heat_map", heat_columns());
  }

  PassResources m_resources;
  LightPrograms m_programs;
  LookRows m_looks;
  GlObject m_brdf;
  Eigen::Matrix4Xf m_matt;
  GlObject m_mirrored;
};

} // namespace

Result<std::unique_ptr<Pass>> create_light_pass(const PassResources& resources) {
  const LightState lights = light_state(resources.plan, 0.0, 0, 1);
  LightPrograms programs;
  for (const auto& [program, what, source] :
       {std::tuple(&programs.touched, "touched surround light",
                   surround_fragment_shader(resources.plan, lights, Surround::touched)),
        std::tuple(&programs.open, "open surround light",
                   surround_fragment_shader(resources.plan, lights, Surround::open)),
        std::tuple(&programs.subject, "subject light",
                   subject_fragment_shader(resources.plan, lights, Colouring::look)),
        std::tuple(&programs.clay, "clay light", subject_fragment_shader(resources.plan, lights, Colouring::clay)),
        std::tuple(&programs.heat, "heat light", subject_fragment_shader(resources.plan, lights, Colouring::heat))}) {
    Result<Program> made = Program::create(resources.gl, what, FULL_SCREEN_VERTEX_SHADER, source);
    if (!made.ok())
      return made.error();
    *program = std::move(*made);
  }
  Result<Program> clear = Program::create(resources.gl, "clear light", clear_vertex_shader(),
                                          clear_fragment_shader(resources.plan, lights));
  if (!clear.ok())
    return clear.error();
  programs.clear = std::move(*clear);
  Result<Program> sum = Program::create(resources.gl, "sum", FULL_SCREEN_VERTEX_SHADER, SUM_SHADER);
  if (!sum.ok())
    return sum.error();
  programs.sum = std::move(*sum);
  return std::unique_ptr<Pass>(std::make_unique<LightPass>(resources, std::move(programs)));
}

} // namespace wry::render
