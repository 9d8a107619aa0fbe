#pragma once

#include <vector>

#include "render/view.h"
#include "sim/base/result.h"
#include "sim/state/frame.h"

namespace wry::render {

/// A channel as a heat view sees it: one number per row, from 0 at the style's low end to 1 at its high end.
struct HeatValues {
  ChannelOn on = ChannelOn::vertex;
  std::vector<float> rows; ///< empty: the body has no such channel
};

/// Errors: bad_input when the channel's size does not match the body, when the component is not there, or when the
/// channel is of particles or global.
Result<HeatValues> heat_values(const HeatStyle& style, const SceneBody& body, const FrameBody& on_frame);

} // namespace wry::render
