#pragma once

#include <memory>
#include <vector>

#include "pipeline/measure/measure.h"
#include "sim/scene/collider.h"

namespace wry::pipeline {

/// The surfaces that are drawn of colliders, with exact distances: not the level sets that the simulation reads.
class DrawnColliders {
public:
  explicit DrawnColliders(std::vector<std::shared_ptr<const scene::Collider>> colliders);
  ~DrawnColliders();

  /// Distance to the nearest of them at a time [m], negative inside; infinite beyond `reach` [m].
  class At;

private:
  struct Surface;
  std::vector<std::unique_ptr<const Surface>> m_surfaces;
};

/// How many of a body's grains have their centre inside a collider.
double grains_inside(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame);

/// Gap below a grain at rest [m], from its underside as it lies flat to the nearest collider, that 99 % do not exceed
/// of those that stand still and have no other grain within a grain's length beneath them. (At the top of a bounce one
/// stands still, too.)
double grain_hover(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame);

} // namespace wry::pipeline
