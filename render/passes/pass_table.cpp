#include "render/passes/pass.h"

#include <array>

namespace wry::render {
namespace {

bool always(const RenderPlan&, const View&) {
  return true;
}

bool has_mapped_shadow(const RenderPlan& plan, const View&) {
  for (const Light& light : plan.rig.lights) {
    if (light.shadow == Light::Shadow::mapped)
      return true;
  }
  return false;
}

/// The penumbra's width comes from the same pass.
bool has_occlusion(const RenderPlan& plan, const View& view) {
  return plan.rig.occlusion == Rig::Occlusion::near_by || has_mapped_shadow(plan, view);
}

PassRate each(const RenderPlan&) {
  return PassRate::sub_frame;
}

PassRate once_at_the_end(const RenderPlan&) {
  return PassRate::last_sub_frame;
}

/// Once a picture is enough while the picture stands still; what moves or is out of focus needs its own each time.
PassRate occlusion_rate(const RenderPlan& plan) {
  const bool blurred = plan.samples > 1 && (plan.shutter > 0.0 || plan.camera.f_stop.has_value());
  return blurred ? PassRate::sub_frame : PassRate::first_sub_frame;
}

constexpr std::array PASSES = {
    PassEntry{"shadow", each, has_mapped_shadow, create_shadow_pass},
    PassEntry{"surface", each, always, create_surface_pass},
    PassEntry{"occlusion", occlusion_rate, has_occlusion, create_occlusion_pass},
    PassEntry{"light", each, always, create_light_pass},
    PassEntry{"tone", once_at_the_end, always, create_tone_pass},
};

} // namespace

std::span<const PassEntry> pass_table() {
  return PASSES;
}

} // namespace wry::render
