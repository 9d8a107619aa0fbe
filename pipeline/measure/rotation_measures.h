#pragma once

#include "pipeline/measure/measure.h"

/// Measures of microrotations, curvature and the curve that a body forms. All are NaN when the frame lacks a channel.
namespace wry::pipeline {

/// The largest angle between the microrotations of two nodes of an element [degrees].
double element_twist_max(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);

/// The mean angle between microrotation and the rotation of the matter, the polar factor of F [degrees]: at nodes
/// (against the mean F around the node, weighted by volume), at quadrature points, or in the middle of elements (the
/// mean of the nodes' rotations on the sphere).
double rotation_distance(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);

/// The largest relative error of the wryness at quadrature points, against the spherical average of the nodes'
/// rotations, differentiated.
double curvature_error(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);

/// The largest angle at quadrature points between a rule of interpolation and the spherical average [degrees].
double rotation_interpolation_error(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);

/// Radius and pitch of the helix that the middle half of a slender body forms [m]: means over the screws that take one
/// of 24 slices along its longest side to the next. A ring has pitch 0.
double curve_radius(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);
double curve_pitch(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame);

} // namespace wry::pipeline
