#pragma once

#include <string>
#include <vector>

#include "render/render_plan.h"
#include "shots/shot.h"
#include "sim/base/result.h"

namespace wry::pipeline {

/// The least and the greatest value of a channel over a sequence.
struct ValueRange {
  double low = 0.0;
  double high = 1.0;
};

/// What of the sequence the pictures depend on, gathered from the cached frames.
struct SequenceFacts {
  render::SubjectBounds bounds;
  std::vector<ValueRange> heat; ///< per view of the shot; only those of heat views count
};

/// Everything that the renderer needs, from the shot and the sequence. Errors: bad_input with the key's line.
Result<render::RenderPlan> compile_render(const shots::Shot& shot, const SequenceFacts& facts,
                                          const render::CameraPlan& camera, render::GlBackend backend);

/// Linear Rec. 709 from sRGB in 0..1.
Eigen::Vector3f linear_colour(const Vec3& srgb);

/// The unit of a channel that the frames have, for colour bars; empty when it has none.
std::string channel_unit(const std::string& channel);

/// Gives every body and collider of a cached scene the look that the shot names now, and takes the triangles from
/// colliders that are not shown: neither makes frames stale.
void dress_scene(const shots::Shot& shot, SceneStatic& scene);

} // namespace wry::pipeline
