#pragma once

#include "pipeline/measure/measure.h"

namespace wry::pipeline {

using PointMap = Eigen::Map<const Points>;

/// A channel of three components, n x 3; empty when the body has none of that name.
PointMap point_channel(const FrameBody& body, const std::string& name);

// Measures of piles of particles; NaN without particles.

/// (98 % quantile of the distance from the start's middle, along the measure's direction or, when that is up, around
/// up) over half the width of the start, minus 1.
double run_out(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);
/// 98 % quantile of the coordinate along the measure's direction [m].
double front_position(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);
/// Of the highest particle above the foot of the start [m].
double pile_height(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);
/// Slope of the straight line through the pile's surface, between a fifth and four fifths of its height [degrees].
double repose_angle(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);
/// Part of the particles that are not in the plan's region.
double fraction_outside(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);

} // namespace wry::pipeline
