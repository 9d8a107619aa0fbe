#include "sim/mpm/matter/constitutive_reference.h"

#include <cmath>

#include "sim/mpm/matter/elastic_law.h"
#include "sim/mpm/matter/plastic_law.h"
#include "sim/mpm/matter/stretch.h"

namespace wry::mpm {

namespace {

/// Biot strains cannot pass through zero stretch.
constexpr double LEAST_STRETCH = 0.05;

/// f(V) in the axes of the material, and the other way round.
Mat3 spectral(const Mat3& axes, const Vec3& values) {
  return axes * values.asDiagonal() * axes.transpose();
}

/// G_ab of spec S4: makes the stress conjugate to the strain measure.
double conjugacy_weight(double a, double b, StrainMeasure measure) {
  if (measure == StrainMeasure::biot)
    return 2.0 * (1.0 + a) * (1.0 + b) / (2.0 + a + b);
  const double x = a - b;
  return std::abs(x) < 1e-4 ? 1.0 - x * x / 6.0 : x / std::sinh(x);
}

/// tau in the axes of the material, from the stress T there and the strain's eigensystem.
Mat3 conjugate_stress(const Mat3& T, const SymmetricEigen& strain, StrainMeasure measure) {
  Mat3 t = strain.vectors.transpose() * T * strain.vectors;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b)
      t(a, b) *= conjugacy_weight(strain.values[a], strain.values[b], measure);
  }
  return strain.vectors * t * strain.vectors.transpose();
}

struct Returned {
  Mat3 strain, stress; ///< fictitious
  bool moved;
};

Returned return_map(const Matter& matter, const Mat3& fictitious_strain, PlasticHistory& history) {
  SymmetricEigen eigen = symmetric_eigen(fictitious_strain);
  ReturnContext context{matter};
  for (int a = 0; a < 3; ++a) {
    const Vec3 n = eigen.vectors.col(a);
    context.volume_per_strain[a] = (matter.maps.strain_inverse * to_mandel(n * n.transpose())).head<3>().sum();
  }
  Returned returned;
  returned.moved = plastic_law(matter.plasticity.law).project(eigen.values, history, context) == Yield::plastic;
  returned.strain = returned.moved ? spectral(eigen.vectors, eigen.values) : fictitious_strain;
  const Vec3 stress = hardening_factor(matter.plasticity, history) *
                      elastic_law(matter.elasticity).stress(eigen.values, matter.measure, matter.fictitious);
  returned.stress = spectral(eigen.vectors, stress);
  return returned;
}

} // namespace

ConstitutiveStep constitutive_step(const Matter& matter, const Mat3& F_trial, const Mat3& frame,
                                   const PlasticHistory& history) {
  const LeftPolar polar = left_polar(F_trial);
  const Vec3 strains = strains_of(polar.stretches, matter.measure);
  ConstitutiveStep step;
  step.history = history;
  step.strain = frame.transpose() * spectral(polar.axes, strains) * frame;

  Mat3 start = step.strain;
  const double corrected = history.volume_correction;
  if (matter.plasticity.volume_correction)
    start += corrected / 3.0 * Mat3::Identity();
  step.fictitious_strain = from_mandel(matter.maps.strain * to_mandel(start));
  const Returned returned = return_map(matter, step.fictitious_strain, step.history);
  step.projected_strain = returned.strain;
  step.fictitious_stress = returned.stress;
  step.yielded = returned.moved || (matter.plasticity.volume_correction && corrected != 0.0);

  const Vec6 plastic = to_mandel(returned.strain - step.fictitious_strain);
  Mat3 elastic = start + from_mandel(matter.maps.strain_inverse * plastic);
  if (matter.plasticity.volume_correction)
    step.history.volume_correction = std::max(0.0, corrected + step.strain.trace() - elastic.trace());
  SymmetricEigen eigen = symmetric_eigen(elastic);
  if (matter.measure == StrainMeasure::biot)
    eigen.values = eigen.values.cwiseMax(LEAST_STRETCH - 1.0);
  step.F = F_trial;
  if (step.yielded) {
    const Mat3 V = spectral(eigen.vectors, stretches_of(eigen.values, matter.measure));
    step.F = frame * V * frame.transpose() * polar.rotation;
  }
  const Mat3 T = from_mandel(matter.maps.stress_inverse * to_mandel(returned.stress));
  const Mat3 local = matter.conjugacy == StressConjugacy::exact ? conjugate_stress(T, eigen, matter.measure) : T;
  step.kirchhoff = frame * local * frame.transpose();
  return step;
}

double elastic_energy_density(const Matter& matter, const Mat3& strain) {
  const Vec6 e = to_mandel(strain);
  return 0.5 * e.dot(matter.stiffness * e);
}

} // namespace wry::mpm
