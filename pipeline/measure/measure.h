#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shots/shot.h"
#include "sim/scene/region.h"
#include "sim/state/frame.h"

namespace wry::pipeline {

class DrawnColliders;

/// A measure ready to be evaluated: names resolved, nodes picked.
struct MeasurePlan {
  std::string name; ///< column in measure.csv
  shots::MeasureKind kind = shots::MeasureKind::height;
  std::size_t body = 0;                                  ///< index into SceneStatic::bodies
  Vec3 direction = Vec3::UnitY();                        ///< unit: the shot's up for height, else the measure's axis
  Vec3 up = Vec3::UnitY();                               ///< unit: the shot's
  double density = 0.0;                                  ///< of the body [kg/m^3]
  double cell = 0.0;                                     ///< of the particles' grid [m]
  double particle_mass = 0.0;                            ///< of bodies of particles [kg]
  Vec3 start_low = Vec3::Zero();                         ///< of bodies of particles: the box they fill at the start [m]
  Vec3 start_high = Vec3::Zero();                        ///< [m]
  std::optional<scene::Region> region;                   ///< of fraction_outside and pile_height, in space
  std::shared_ptr<const DrawnColliders> drawn_colliders; ///< of what grains are measured against
  std::optional<Vec3> about; ///< of torques and angular momenta [m]; absent: the middle of the nodes
  shots::MeasureAt at = shots::MeasureAt::nodes;
  shots::PointRotations rule = shots::PointRotations::velocity;
  std::vector<std::int32_t> nodes; ///< those it looks at; empty: all
  std::optional<double> reference; ///< divide by this value (that of the first frame) when the measure is relative
};

/// Which bodies a kind is measured on.
enum class MeasuredOn { solids, particles, both };

/// One kind of measure: a number per frame.
struct MeasureFunction {
  shots::MeasureKind kind;
  std::string_view name; ///< as in the shot file
  std::string_view unit;
  std::string_view doc;
  MeasuredOn on;
  double (*evaluate)(const MeasurePlan&, const SceneBody&, const FrameBody&); ///< null: of more than its body
  double (*evaluate_in_scene)(const MeasurePlan&, const SceneStatic&, const Frame&) = nullptr;
};

/// Every kind that this build has.
std::span<const MeasureFunction> measure_functions();

MeasuredOn measured_on(shots::MeasureKind kind);

/// The value on a frame, before division by the reference; NaN when the frame lacks the channel it needs.
double evaluate_measure(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame);

/// evaluate_measure() divided by the reference where there is one.
double measured_value(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame);

} // namespace wry::pipeline
