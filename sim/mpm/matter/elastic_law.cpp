#include "sim/mpm/matter/elastic_law.h"

#include <array>
#include <cmath>

namespace wry::mpm {

namespace {

Vec3 linear_stress(const Vec3& e, StrainMeasure, const LameModuli& moduli) {
  return (2.0 * moduli.mu * e).array() + moduli.lambda * e.sum();
}

Vec3 fixed_corotated_stress(const Vec3& e, StrainMeasure measure, const LameModuli& moduli) {
  const Vec3 s = stretches_of(e, measure);
  const double J = s.prod();
  const Vec3 kirchhoff = (2.0 * moduli.mu * s.array() * (s.array() - 1.0)) + moduli.lambda * (J - 1.0) * J;
  return measure == StrainMeasure::hencky ? kirchhoff : kirchhoff.cwiseQuotient(s);
}

constexpr std::array LAWS = {ElasticLaw{Elasticity::linear, linear_stress},
                             ElasticLaw{Elasticity::hencky, linear_stress},
                             ElasticLaw{Elasticity::fixed_corotated, fixed_corotated_stress}};

} // namespace

const ElasticLaw& elastic_law(Elasticity elasticity) {
  return LAWS[static_cast<std::size_t>(elasticity)];
}

Vec3 stretches_of(const Vec3& strains, StrainMeasure measure) {
  return measure == StrainMeasure::hencky ? Vec3(strains.array().exp()) : Vec3(strains.array() + 1.0);
}

Vec3 strains_of(const Vec3& stretches, StrainMeasure measure) {
  return measure == StrainMeasure::hencky ? Vec3(stretches.array().log()) : Vec3(stretches.array() - 1.0);
}

} // namespace wry::mpm
