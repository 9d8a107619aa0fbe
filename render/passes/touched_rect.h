#pragma once

#include "render/camera.h"
#include "render/passes/light_state.h"

namespace wry::render {

/// A rectangle of the picture, from its lower left corner [pixels].
struct PixelRect {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// The part of the picture that the subject covers or darkens: its outline, its shadow on the floor, and as far about
/// its foot as `reach` [m]. Outside it the floor is evenly lit and needs no shadow or occlusion work. `camera`:
/// relative to the centre of the bounds; `ground_height` likewise.
PixelRect touched_rect(const RenderPlan& plan, const Camera& camera, const LightState& lights, double ground_height,
                       double reach);

} // namespace wry::render
