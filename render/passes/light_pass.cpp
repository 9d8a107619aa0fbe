#include "render/passes/pass.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>

#include "render/brdf_table.h"
#include "render/color_map.h"
#include "render/environment.h"
#include "render/passes/light_shader.h"
#include "render/passes/picture_tiles.h"
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
  Program shaded;
  Program open;
  Program subject;
  Program clay;
  Program heat;
  Program open_subject; ///< where the key light is known to arrive
  Program open_clay;
  Program open_heat;
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
      , m_tiles(resources.targets.size)
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
    gl.BlendFunc(GL_ONE, GL_ONE);
    if (sees_through) {
      draw_everywhere(sub_frame, 1.f);
      draw_clear(sub_frame);
      add_sub_frame(sub_frame);
    } else if (sub_frame.still) {
      draw_tiles(sub_frame);
    } else {
      draw_everywhere(sub_frame, share(sub_frame));
    }
    gl.Disable(GL_BLEND);
    gl.DepthMask(GL_TRUE);
  }

private:
  static float share(const SubFrame& sub_frame) { return 1.f / static_cast<float>(sub_frame.count); }

  /// Adds to what is there, but for the first time.
  void add_or_begin(const SubFrame& sub_frame) const {
    if (sub_frame.index == 0 || m_resources.geometry.has_clear())
      m_resources.gl.Disable(GL_BLEND);
    else
      m_resources.gl.Enable(GL_BLEND);
  }

  const Program& subject_program(const SubFrame& sub_frame, KeyLight key) const {
    const bool open = key == KeyLight::open;
    const Colouring colouring = sub_frame.view->colouring;
    return colouring == Colouring::heat   ? (open ? m_programs.open_heat : m_programs.heat)
           : colouring == Colouring::look ? (open ? m_programs.open_subject : m_programs.subject)
                                          : (open ? m_programs.open_clay : m_programs.clay);
  }

  void draw_everywhere(const SubFrame& sub_frame, float weight) {
    const GlFunctions& gl = m_resources.gl;
    add_or_begin(sub_frame);
    const PixelRect& touched = sub_frame.touched;
    // The triangle lies at the far plane: what has no depth is surround, what is nearer is subject.
    gl.DepthFunc(GL_EQUAL);
    draw_with(m_programs.shaded, sub_frame, weight, {touched});
    draw_with(m_programs.open, sub_frame, weight, around(touched, m_resources.targets.size));
    gl.DepthFunc(GL_LESS);
    draw_with(subject_program(sub_frame, KeyLight::shaded), sub_frame, weight, {touched});
  }

  /// As draw_everywhere(), but floor and backdrop away from the subject once for all sub-frames, in the last.
  void draw_tiles(const SubFrame& sub_frame) {
    const GlFunctions& gl = m_resources.gl;
    if (sub_frame.index == 0)
      begin_tiles(sub_frame);
    const GLuint depth = m_resources.targets.depth.name();
    gl.GetTextureImage(depth, 0, GL_DEPTH_COMPONENT, GL_FLOAT, static_cast<GLsizei>(m_depth.size() * sizeof(float)),
                       m_depth.data());
    m_tiles.take_depths(m_depth);
    gl.Disable(GL_BLEND);
    gl.Disable(GL_DEPTH_TEST);
    if (sub_frame.index > 0)
      draw_with(m_programs.open, sub_frame, static_cast<float>(sub_frame.index) * share(sub_frame),
                m_tiles.newly_busy());
    if (sub_frame.index + 1 == sub_frame.count)
      draw_with(m_programs.open, sub_frame, 1.f, m_tiles.still());
    gl.Enable(GL_DEPTH_TEST);
    add_or_begin(sub_frame);
    gl.DepthFunc(GL_EQUAL);
    draw_with(m_programs.shaded, sub_frame, share(sub_frame), m_tiles.shaded_floor());
    draw_with(m_programs.open, sub_frame, share(sub_frame), m_tiles.open_floor());
    gl.DepthFunc(GL_LESS);
    draw_with(subject_program(sub_frame, KeyLight::shaded), sub_frame, share(sub_frame), m_tiles.shaded_subject());
    draw_with(subject_program(sub_frame, KeyLight::open), sub_frame, share(sub_frame), m_tiles.open_subject());
  }

  void begin_tiles(const SubFrame& sub_frame) {
    const GlFunctions& gl = m_resources.gl;
    const ImageSize& size = m_resources.targets.size;
    const RenderPlan& plan = m_resources.plan;
    m_depth.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
    m_tiles.clear();
    if (sub_frame.lights.shadowed >= 0 && sub_frame.lights.blockers_found()) {
      m_occlusion.resize(m_depth.size());
      gl.GetTextureImage(m_resources.targets.occlusion.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE,
                         static_cast<GLsizei>(4 * m_occlusion.size()), m_occlusion.data());
      m_tiles.take_blockers(m_occlusion);
    } else if (sub_frame.lights.shadowed >= 0) {
      m_tiles.keep_drawing(sub_frame.touched);
    }
    // A backdrop of its own colour meets the floor in an edge.
    if (plan.rig.backdrop == Rig::Backdrop::given && plan.ground.kind != Ground::Kind::none)
      m_tiles.keep_drawing({0, 0, size.width, size.height});
  }

  /// Far walls before near ones.
  void draw_clear(const SubFrame& sub_frame) {
    const GlFunctions& gl = m_resources.gl;
    m_programs.clear.use();
    bind_textures(m_programs.clear);
    set_frame(m_programs.clear, sub_frame);
    m_programs.clear.set("weight", 1.f);
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

  void draw_with(const Program& program, const SubFrame& sub_frame, float weight, const std::vector<PixelRect>& rects) {
    if (rects.empty())
      return;
    program.use();
    bind_textures(program);
    set_frame(program, sub_frame);
    program.set("weight", weight);
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
    set_key_taps(program, sub_frame);
    program.set("ground_colour", m_resources.plan.ground.colour);
    program.set("catch_shadow", m_resources.plan.ground.kind == Ground::Kind::catch_shadow ? 1 : 0);
    program.set("show_around", m_resources.plan.rig.backdrop == Rig::Backdrop::surroundings ? 1 : 0);
  }

  static void set_key_taps(const Program& program, const SubFrame& sub_frame) {
    const int sharing = sub_frame.lights.frames_per_map;
    const int all = sharing * sub_frame.lights.key_taps;
    const int map_number = sub_frame.index / sharing;
    program.set("noise_turn", static_cast<float>(map_number) * 0.618034f);
    // The points of one spiral in turn (Vogel 1979), so that the sub-frames of a map fill its disc together.
    Eigen::Matrix4Xf taps = Eigen::Matrix4Xf::Zero(4, sub_frame.lights.key_taps);
    for (int i = 0; i < sub_frame.lights.key_taps; ++i) {
      const int point = sharing * i + sub_frame.index % sharing;
      const double radius = std::sqrt((point + 0.5) / all);
      const double angle = point * std::numbers::pi * (3.0 - std::sqrt(5.0));
      taps.col(i).head<2>() << static_cast<float>(radius * std::cos(angle)),
          static_cast<float>(radius * std::sin(angle));
    }
    program.set_array("key_taps", taps);
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
  PictureTiles m_tiles;
  std::vector<float> m_depth; ///< of the sub-frame, as the tiles read it
  std::vector<std::array<std::uint8_t, 4>> m_occlusion;
  GlObject m_brdf;
  Eigen::Matrix4Xf m_matt;
  GlObject m_mirrored;
};

} // namespace

Result<std::unique_ptr<Pass>> create_light_pass(const PassResources& resources) {
  const LightState lights = light_state(resources.plan, 0.0, 0, resources.plan.samples);
  const bool coated = std::any_of(resources.looks.begin(), resources.looks.end(),
                                  [](const Look& look) { return look.clearcoat > 0.f; });
  const Coats coats = coated ? Coats::some : Coats::none;
  const auto subject = [&](Colouring colouring, Coats layers, KeyLight key) {
    return subject_fragment_shader(resources.plan, lights, colouring, layers, key);
  };
  LightPrograms programs;
  for (const auto& [program, what, source] :
       {std::tuple(&programs.shaded, "shaded surround light",
                   surround_fragment_shader(resources.plan, lights, KeyLight::shaded)),
        std::tuple(&programs.open, "open surround light",
                   surround_fragment_shader(resources.plan, lights, KeyLight::open)),
        std::tuple(&programs.subject, "subject light", subject(Colouring::look, coats, KeyLight::shaded)),
        std::tuple(&programs.clay, "clay light", subject(Colouring::clay, Coats::none, KeyLight::shaded)),
        std::tuple(&programs.heat, "heat light", subject(Colouring::heat, Coats::none, KeyLight::shaded)),
        std::tuple(&programs.open_subject, "open subject light", subject(Colouring::look, coats, KeyLight::open)),
        std::tuple(&programs.open_clay, "open clay light", subject(Colouring::clay, Coats::none, KeyLight::open)),
        std::tuple(&programs.open_heat, "open heat light", subject(Colouring::heat, Coats::none, KeyLight::open))}) {
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
