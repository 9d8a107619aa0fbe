#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shots/shot.h"
#include "sim/state/frame.h"

namespace wry::pipeline {

/// A measure ready to be evaluated: names resolved, nodes picked.
struct MeasurePlan {
  std::string name; ///< column in measure.csv
  shots::MeasureKind kind = shots::MeasureKind::height;
  std::size_t body = 0;            ///< index into SceneStatic::bodies
  Vec3 direction = Vec3::UnitY();  ///< unit: the shot's up for height, else the measure's axis
  double density = 0.0;            ///< of the body [kg/m^3]
  std::vector<std::int32_t> nodes; ///< those it looks at; empty: all
  std::optional<double> reference; ///< divide by this value (that of the first frame) when the measure is relative
};

/// One kind of measure: a number per frame.
struct MeasureFunction {
  shots::MeasureKind kind;
  std::string_view name; ///< as in the shot file
  std::string_view unit;
  std::string_view doc;
  double (*evaluate)(const MeasurePlan&, const SceneBody&, const FrameBody&);
};

/// Every kind that this build has.
std::span<const MeasureFunction> measure_functions();

/// The value on a frame, before division by the reference; NaN when the frame lacks the channel it needs.
double evaluate_measure(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame);

/// evaluate_measure() divided by the reference where there is one.
double measured_value(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame);

} // namespace wry::pipeline
