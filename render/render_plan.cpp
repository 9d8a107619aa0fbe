#include "render/render_plan.h"

#include <cmath>

namespace wry::render {
namespace {

Status check_look(const std::string& name, const Look& look) {
  const auto within = [](float value, float low, float high) { return value >= low && value <= high; };
  if (!within(look.roughness, 0.05f, 1.f) || !within(look.clearcoat_roughness, 0.05f, 1.f))
    return make_error(ErrorCode::bad_input, "look {}: roughness {} and clearcoat roughness {} must be 0.05 to 1", name,
                      look.roughness, look.clearcoat_roughness);
  if (!within(look.metallic, 0.f, 1.f) || !within(look.specular, 0.f, 1.f) || !within(look.wrap, 0.f, 1.f) ||
      !within(look.clearcoat, 0.f, 1.f))
    return make_error(ErrorCode::bad_input,
                      "look {}: metallic {}, specular {}, wrap {} and clearcoat {} must be 0 to 1", name, look.metallic,
                      look.specular, look.wrap, look.clearcoat);
  if (!within(look.transparency, 0.f, 1.f) || !within(look.colour_variation, 0.f, 0.6f) ||
      !within(look.size_variation, 0.f, 0.9f))
    return make_error(
        ErrorCode::bad_input,
        "look {}: transparency {} must be 0 to 1, colour variation {} 0 to 0.6, size variation {} 0 to 0.9", name,
        look.transparency, look.colour_variation, look.size_variation);
  for (int c = 0; c < 3; ++c) {
    if (!within(look.base_colour[c], 0.f, 1.f) || !within(look.scatter[c], 0.f, 1.f))
      return make_error(ErrorCode::bad_input, "look {}: colours must be 0 to 1, linear", name);
  }
  return {};
}

Status check_view(const View& view) {
  if (view.colouring != Colouring::heat)
    return {};
  if (!view.heat.has_value())
    return make_error(ErrorCode::bad_input, "view {}: a heat view needs a channel and a range", view.name);
  if (!(view.heat->low < view.heat->high) || !std::isfinite(view.heat->high - view.heat->low))
    return make_error(ErrorCode::bad_input, "view {}: the range {} to {} of channel {} is empty or not finite",
                      view.name, view.heat->low, view.heat->high, view.heat->channel);
  return {};
}

Status check_rig(const Rig& rig) {
  int mapped = 0;
  for (const Light& light : rig.lights)
    mapped += light.shadow == Light::Shadow::mapped ? 1 : 0;
  if (rig.lights.size() > 4 || mapped > 1)
    return make_error(ErrorCode::bad_input, "{} lights, {} of them with shadows: at most 4, and 1 with shadows",
                      rig.lights.size(), mapped);
  return {};
}

} // namespace

Status check_render_plan(const RenderPlan& plan) {
  if (plan.samples < 1 || plan.samples > 256)
    return make_error(ErrorCode::bad_input, "{} samples a picture: choose 1 (draft) to 256; 4 is usual", plan.samples);
  if (!(std::abs(plan.exposure_stops) <= 16.0))
    return make_error(ErrorCode::bad_input, "an exposure of {} stops: choose -16 to 16", plan.exposure_stops);
  if (!(std::abs(plan.up.norm() - 1.0) < 1e-6))
    return make_error(ErrorCode::bad_input, "the up axis must be a unit vector; its length is {}", plan.up.norm());
  if (!(plan.shutter >= 0.0 && plan.shutter <= 1.0) || !(plan.fps > 0.0))
    return make_error(ErrorCode::bad_input, "a shutter of {} of a frame at {} frames a second: choose 0 to 1",
                      plan.shutter, plan.fps);
  if (const Status good = check_look("default", plan.default_look); !good.ok())
    return good;
  for (const auto& [name, look] : plan.looks) {
    if (const Status good = check_look(name, look); !good.ok())
      return good;
  }
  for (const View& view : plan.views) {
    if (const Status good = check_view(view); !good.ok())
      return good;
  }
  return check_rig(plan.rig);
}

Result<View> find_view(const RenderPlan& plan, const std::string& name) {
  std::string names;
  for (const View& view : plan.views) {
    if (view.name == name)
      return view;
    names += (names.empty() ? "" : ", ") + view.name;
  }
  return make_error(ErrorCode::bad_input, "there is no view {}: this plan has {}", name, names);
}

} // namespace wry::render
