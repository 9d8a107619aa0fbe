#include "pipeline/plan/compile_render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "pipeline/plan/compile_fem.h"

namespace wry::pipeline {

namespace {

// Reflectance of dielectrics in the renderer: specular 0.5 is 4 % at normal incidence.
constexpr double SPECULAR_PER_REFLECTANCE = 0.5 / 0.04;

render::Look compile_look(const shots::Look& look) {
  render::Look compiled;
  compiled.base_colour = linear_colour(*look.colour);
  compiled.roughness = std::max(0.05f, static_cast<float>(*look.roughness));
  compiled.metallic = static_cast<float>(*look.metallic);
  compiled.specular = static_cast<float>(std::min(1.0, *look.specular * SPECULAR_PER_REFLECTANCE));
  compiled.wrap = static_cast<float>(*look.wrap);
  // Light that creeps through soft matter takes the colour of the matter.
  compiled.scatter = compiled.base_colour / std::max(1e-3f, compiled.base_colour.maxCoeff());
  return compiled;
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

render::CameraPlan compile_camera(const shots::Camera& camera, const render::SubjectBounds& bounds) {
  render::CameraPlan compiled;
  compiled.lens_mm = *camera.lens;
  compiled.azimuth_degrees = *camera.azimuth_deg;
  compiled.elevation_degrees = *camera.elevation_deg;
  compiled.margin = *camera.margin;
  if (camera.position)
    compiled.placed = render::PlacedCamera{**camera.position, camera.target ? **camera.target : bounds.centre()};
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
                                          render::GlBackend backend) {
  render::RenderPlan plan;
  const shots::RenderOptions& asked = shot.render;
  plan.size = {static_cast<int>((*asked.size)[0]), static_cast<int>((*asked.size)[1])};
  plan.samples = static_cast<int>(*asked.samples);
  plan.up = axis_vector(*shot.shot.up);
  plan.camera = compile_camera(asked.camera, facts.bounds);
  plan.exposure_stops = *asked.exposure;
  plan.bounds = facts.bounds;
  plan.backend = backend;
  plan.ground.kind = *asked.ground.show ? render::Ground::Kind::studio : render::Ground::Kind::none;
  plan.ground.height = ground_height(shot);
  plan.ground.colour = linear_colour(*asked.ground.colour);
  if (!*asked.shadows) {
    for (render::Light& light : plan.rig.lights)
      light.shadow = render::Light::Shadow::none;
  }
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
