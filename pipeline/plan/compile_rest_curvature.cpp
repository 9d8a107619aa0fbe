#include <array>
#include <limits>
#include <memory>
#include <optional>

#include "pipeline/plan/compile_fem.h"
#include "sim/scene/expression.h"

namespace wry::pipeline {

namespace {

/// The nine formulas of Gamma0, row by row; absent ones are zero.
using Formulas = std::array<std::optional<scene::Expression>, 9>;

Mat3 evaluate(const Formulas& formulas, const Vec3& position, double time) {
  scene::ExpressionPoint point;
  point.time = time;
  point.position = position;
  Mat3 value = Mat3::Zero();
  for (int i = 0; i < 9; ++i) {
    if (!formulas[i])
      continue;
    const Result<double> number = formulas[i]->evaluate(point);
    // Not a number on purpose: the solver refuses a strain that is not finite, with time and element.
    value(i / 3, i % 3) = number ? *number : std::numeric_limits<double>::quiet_NaN();
  }
  return value;
}

} // namespace

Result<fem::RestCurvature> compile_rest_curvature(const shots::Material& material) {
  if (!material.has_rest_curvature())
    return fem::RestCurvature();
  auto formulas = std::make_shared<Formulas>();
  for (int i = 0; i < 9; ++i) {
    const std::optional<shots::Located<shots::Expression>>& asked = material.rest_curvature[i / 3][i % 3];
    if (!asked)
      continue;
    Result<scene::Expression> compiled = scene::Expression::compile((*asked)->text);
    if (!compiled)
      return at_source(asked->source, compiled.error());
    for (const char* name : {"u", "v"}) {
      if (compiled->uses(name))
        return at_source(
            asked->source,
            make_error(ErrorCode::unavailable, "rest curvature of {} is not in this build yet; use X, Y, Z, t", name));
    }
    // A formula that has no value at all is better known now than at the first step.
    if (const Result<double> probe = compiled->evaluate({}); !probe)
      return at_source(asked->source, probe.error());
    (*formulas)[i] = std::move(*compiled);
  }
  return fem::RestCurvature(
      [formulas](const Vec3& position, double time) { return evaluate(*formulas, position, time); });
}

} // namespace wry::pipeline
