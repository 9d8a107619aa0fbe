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

constexpr std::array PASSES = {
    PassEntry{"shadow", PassRate::sub_frame, has_mapped_shadow, create_shadow_pass},
    PassEntry{"surface", PassRate::sub_frame, always, create_surface_pass},
    PassEntry{"occlusion", PassRate::first_sub_frame, has_occlusion, create_occlusion_pass},
    PassEntry{"light", PassRate::sub_frame, always, create_light_pass},
    PassEntry{"tone", PassRate::last_sub_frame, always, create_tone_pass},
};

} // namespace

std::span<const PassEntry> pass_table() {
  return PASSES;
}

} // namespace wry::render
