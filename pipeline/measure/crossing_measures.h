#pragma once

#include <vector>

#include "pipeline/measure/measure.h"
#include "sim/contact/surface.h"

namespace wry::pipeline {

/// The surfaces of all solids of a scene in one numbering of nodes, a part per solid; nothing may meet yet.
struct SolidSurfaces {
  std::vector<std::size_t> bodies; ///< of each part: its place in SceneStatic::bodies
  contact::Surface surface;

  /// Places of all nodes in a frame (nodes x 3) [m]; empty when it lacks a solid.
  Points positions_in(const Frame& frame) const;
};
SolidSurfaces solid_surfaces(const SceneStatic& scene);

/// How many pairs of an edge and a triangle of a body with itself and with other solids cut or touch each other,
/// exactly. With nodes picked: those pairs that have one of them. NaN when the frame lacks a solid.
double crossings(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame);

} // namespace wry::pipeline
