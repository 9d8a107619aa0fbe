#include "pipeline/plan/compile_render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "pipeline/plan/compile_fem.h"
#include "render/environment.h"

namespace wry::pipeline {

namespace {

// Reflectance of dielectrics in the renderer: specular 0.5 is 4 % at normal incidence.
constexpr double SPECULAR_PER_REFLECTANCE = 0.5 / 0.04;

/// A key that is given wins over the look to start from.
template <class T> void take(T& into, const T& value, const shots::Source& source, bool has_start) {
  if (!has_start || source.given())
    into = value;
}

render::Look compile_look(const shots::Look& look) {
  render::Look compiled;
  const bool has_start = look.like.has_value();
  if (has_start)
    compiled = render::built_in_looks().at(**look.like);
  const auto number = [&](float& into, const shots::Located<double>& key) {
    take(into, static_cast<float>(*key), key.source, has_start);
  };
  take(compiled.base_colour, linear_colour(*look.colour), look.colour.source, has_start);
  number(compiled.roughness, look.roughness);
  number(compiled.metallic, look.metallic);
  take(compiled.specular, static_cast<float>(std::min(1.0, *look.specular * SPECULAR_PER_REFLECTANCE)),
       look.specular.source, has_start);
  number(compiled.wrap, look.wrap);
  number(compiled.clearcoat, look.clearcoat);
  number(compiled.clearcoat_roughness, look.clearcoat_roughness);
  number(compiled.transparency, look.transparency);
  number(compiled.colour_variation, look.colour_variation);
  number(compiled.size_variation, look.size_variation);
  compiled.roughness = std::max(0.05f, compiled.roughness);
  if (look.scatter)
    compiled.scatter = linear_colour(**look.scatter);
  else if (!has_start || look.colour.given()) // light that creeps through soft matter takes the colour of the matter
    compiled.scatter = compiled.base_colour / std::max(1e-3f, compiled.base_colour.maxCoeff());
  return compiled;
}

Result<render::Rig> compile_rig(const shots::RenderOptions& asked) {
  const shots::Lights& lights = asked.lights;
  render::Rig rig = render::studio_rig();
  if (*lights.rig == shots::LightRig::day)
    rig = render::day_rig();
  if (*lights.rig == shots::LightRig::image) {
    if (!lights.image)
      return make_error(ErrorCode::bad_input, "{}: rig = \"image\" needs image = \"a .hdr or .exr file\"",
                        lights.rig.source.text());
    const Result<render::LinearImage> image = render::read_light_image(**lights.image);
    if (!image)
      return at_source(lights.image->source, image.error());
    Result<render::Rig> made = render::image_rig(*image);
    if (!made)
      return at_source(lights.image->source, made.error());
    rig = std::move(*made);
    if (*lights.show_image)
      rig.backdrop = render::Rig::Backdrop::surroundings;
  }
  rig.turn_degrees = *lights.turn_deg;
  rig.stops = *lights.stops;
  if (lights.turn_with)
    rig.turning = **lights.turn_with == "world" ? render::Rig::Turning::with_world : render::Rig::Turning::with_camera;
  if (!*asked.shadows) {
    for (render::Light& light : rig.lights)
      light.shadow = render::Light::Shadow::none;
  }
  return rig;
}

render::Ground compile_ground(const shots::Shot& shot, std::optional<double> height) {
  const shots::Ground& asked = shot.render.ground;
  render::Ground ground;
  ground.kind = !*asked.show          ? render::Ground::Kind::none
                : *asked.catch_shadow ? render::Ground::Kind::catch_shadow
                                      : render::Ground::Kind::studio;
  ground.height = height;
  ground.colour = linear_colour(*asked.colour);
  return ground;
}

render::View compile_view(const shots::View& view, const ValueRange& range) {
  if (view.kind != shots::ViewKind::heat) {
    for (const render::View& standard : render::standard_views()) {
      if (standard.name == view.name)
        return standard;
    }
  }
  render::HeatStyle style;
  style.channel = view.channel;
  style.low = range.low;
  style.high = range.high;
  style.unit = channel_unit(view.channel);
  render::View compiled = render::heat_view(style);
  compiled.name = view.name;
  return compiled;
}

std::optional<double> ground_height(const shots::Shot& shot) {
  if (shot.render.ground.height)
    return **shot.render.ground.height;
  for (const shots::Collider& collider : shot.colliders) {
    const auto* plane = std::get_if<shots::PlaneShape>(&collider.shape);
    const Vec3 up = axis_vector(*shot.shot.up);
    if (plane != nullptr && plane->normal->normalized().dot(up) > 0.999)
      return plane->point->dot(up);
  }
  return std::nullopt;
}

} // namespace

Eigen::Vector3f linear_colour(const Vec3& srgb) {
  Eigen::Vector3f linear;
  for (int i = 0; i < 3; ++i)
    linear[i] = static_cast<float>(srgb[i] <= 0.04045 ? srgb[i] / 12.92 : std::pow((srgb[i] + 0.055) / 1.055, 2.4));
  return linear;
}

std::string channel_unit(const std::string& channel) {
  constexpr std::array<std::pair<const char*, const char*>, 6> UNITS = {{{"speed", "m/s"},
                                                                         {"velocity", "m/s"},
                                                                         {"displacement", "m"},
                                                                         {"strain_energy_density", "J/m3"},
                                                                         {"curvature_energy_density", "J/m3"},
                                                                         {"angular_velocity", "rad/s"}}};
  for (const auto& [name, unit] : UNITS) {
    if (channel == name)
      return unit;
  }
  return "";
}

void dress_scene(const shots::Shot& shot, SceneStatic& scene) {
  for (SceneBody& body : scene.bodies) {
    if (const shots::Body* asked = shot.find_body(body.name); asked != nullptr && body.simulated)
      body.look = asked->look ? **asked->look : std::string();
    const auto collider = std::find_if(shot.colliders.begin(), shot.colliders.end(),
                                       [&](const shots::Collider& one) { return *one.name == body.name; });
    if (body.simulated || collider == shot.colliders.end())
      continue;
    body.look = collider->look ? **collider->look : std::string();
    if (!*collider->show)
      body.triangles.resize(0, 3);
  }
}

Result<render::RenderPlan> compile_render(const shots::Shot& shot, const SequenceFacts& facts,
                                          const render::CameraPlan& camera, render::GlBackend backend) {
  render::RenderPlan plan;
  const shots::RenderOptions& asked = shot.render;
  plan.size = {static_cast<int>((*asked.size)[0]), static_cast<int>((*asked.size)[1])};
  plan.samples = static_cast<int>(*asked.samples);
  plan.up = axis_vector(*shot.shot.up);
  plan.camera = camera;
  if (*asked.camera.orbit_turns != 0.0) // the frame must hold from all around
    plan.framing = render::Framing::orbit;
  plan.exposure_stops = *asked.exposure;
  plan.bounds = facts.bounds;
  plan.backend = backend;
  plan.ground = compile_ground(shot, ground_height(shot));
  Result<render::Rig> rig = compile_rig(asked);
  if (!rig)
    return rig.error();
  plan.rig = std::move(*rig);
  if (asked.background.given()) {
    plan.rig.backdrop = render::Rig::Backdrop::given;
    plan.rig.given_backdrop = linear_colour(*asked.background);
  }
  plan.fps = *shot.shot.fps;
  plan.shutter = *asked.motion_blur;
  plan.tone = *asked.filmic ? render::Tone::filmic : render::Tone::plain;
  plan.bits = static_cast<int>(*asked.bits);
  plan.background = *asked.alpha || *asked.ground.catch_shadow ? render::Background::clear : render::Background::drawn;
  plan.data = asked.exr.empty() ? render::DataWanted::no : render::DataWanted::yes;
  plan.looks = render::built_in_looks();
  for (const shots::Look& look : shot.looks)
    plan.looks[*look.name] = compile_look(look);
  plan.views.clear();
  for (std::size_t i = 0; i < asked.views.size(); ++i)
    plan.views.push_back(compile_view(*asked.views[i], facts.heat[i]));
  if (Status status = render::check_render_plan(plan); !status)
    return at_source(asked.source, status.error());
  return plan;
}

} // namespace wry::pipeline
