#include "sim/mpm/matter/plastic_law.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/mpm/matter/elastic_law.h"

namespace wry::mpm {

namespace {

Yield stay_elastic(Vec3&, PlasticHistory&, const ReturnContext&) {
  return Yield::elastic;
}

Yield project_snow(Vec3& e, PlasticHistory& history, const ReturnContext& context) {
  constexpr double LEAST_STRETCH = 1e-6, LEAST_RATIO = 0.1, GREATEST_RATIO = 10.0;
  const SnowLimits& limits = context.matter.plasticity.snow;
  const Vec3 s = stretches_of(e, context.matter.measure);
  const Vec3 clipped = s.cwiseMax(1.0 - limits.compression).cwiseMin(1.0 + limits.stretch);
  if (clipped == s)
    return Yield::elastic;
  const double growth = s.cwiseAbs().cwiseMax(LEAST_STRETCH).cwiseQuotient(clipped).prod();
  history.volume_ratio = std::clamp(history.volume_ratio * growth, LEAST_RATIO, GREATEST_RATIO);
  e = strains_of(clipped, context.matter.measure);
  return Yield::plastic;
}

/// Along deviator + k I, with the step that lands on the cone; false where the cone cannot be reached that way.
bool flow_isochorically(Vec3& e, const Vec3& deviator, double length, double c, double excess,
                        const ReturnContext& context) {
  const double k = -context.volume_per_strain.dot(deviator) / context.volume_per_strain.sum();
  const double denominator = length + 3.0 * k * c;
  const double step = excess / denominator;
  if (!(denominator > 0.0) || !(step > 0.0) || !(step <= 1.0) || !(e.sum() - 3.0 * step * k <= 0.0))
    return false;
  e -= step * (deviator.array() + k).matrix();
  return true;
}

Yield project_drucker_prager(Vec3& e, PlasticHistory& history, const ReturnContext& context) {
  const YieldRule& plasticity = context.matter.plasticity;
  const LameModuli& moduli = context.matter.fictitious;
  const double alpha = friction_alpha(plasticity.friction, history.flow);
  const double c = (3.0 * moduli.lambda + 2.0 * moduli.mu) * alpha / (2.0 * moduli.mu);
  const double trace = e.sum();
  if (trace >= 0.0) {
    const bool at_rest = e == Vec3::Zero();
    history.flow += e.norm();
    e.setZero();
    return at_rest ? Yield::elastic : Yield::plastic;
  }
  const Vec3 deviator = e.array() - trace / 3.0;
  const double length = deviator.norm();
  const double excess = length + c * trace;
  if (excess <= 0.0)
    return Yield::elastic;
  history.flow += excess;
  if (plasticity.flow == Flow::isochoric && flow_isochorically(e, deviator, length, c, excess, context))
    return Yield::plastic;
  e -= excess / length * deviator;
  return Yield::plastic;
}

Yield project_shear(Vec3& e, PlasticHistory&, const ReturnContext& context) {
  const double k = context.matter.plasticity.shear_limit;
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&e](int a, int b) { return e[a] > e[b]; });
  double &high = e[order[0]], &middle = e[order[1]], &low = e[order[2]];
  const double excess = high - low - k;
  if (excess <= 0.0)
    return Yield::elastic;
  const double mean = e.sum() / 3.0;
  if (middle > high - 0.5 * excess) {
    high = middle = mean + k / 3.0;
    low = mean - 2.0 * k / 3.0;
  } else if (middle < low + 0.5 * excess) {
    high = mean + 2.0 * k / 3.0;
    low = middle = mean - k / 3.0;
  } else {
    high -= 0.5 * excess;
    low += 0.5 * excess;
  }
  return Yield::plastic;
}

constexpr std::array LAWS = {PlasticLaw{Plasticity::none, stay_elastic}, PlasticLaw{Plasticity::snow, project_snow},
                             PlasticLaw{Plasticity::drucker_prager, project_drucker_prager},
                             PlasticLaw{Plasticity::shear, project_shear}};

} // namespace

const PlasticLaw& plastic_law(Plasticity law) {
  return LAWS[static_cast<std::size_t>(law)];
}

double hardening_factor(const YieldRule& plasticity, const PlasticHistory& history) {
  return plasticity.law == Plasticity::snow ? std::exp(plasticity.snow.hardening * (1.0 - history.volume_ratio)) : 1.0;
}

double friction_alpha(const FrictionHardening& friction, double flow) {
  return drucker_prager_alpha(friction.h0 + (friction.h1 * flow - friction.h3) * std::exp(-friction.h2 * flow));
}

} // namespace wry::mpm
