#pragma once

#include "sim/mpm/matter/matter.h"

namespace wry::mpm {

/// All of a constitutive step, intermediate results too.
struct ConstitutiveStep {
  Mat3 F;                 ///< F_e after plastic flow; F_trial itself, bit for bit, without yield
  Mat3 kirchhoff;         ///< tau [Pa], world
  Mat3 strain;            ///< of the trial state, material axes
  Mat3 fictitious_strain; ///< before the return map
  Mat3 projected_strain;  ///< fictitious, after it
  Mat3 fictitious_stress; ///< T-bar
  PlasticHistory history;
  bool yielded = false;
};

/// Strain, plasticity, stress of one particle in double (spec S4 and S5): the reference of the batched kernels and the
/// fall-back for matter without one. F_trial has a positive determinant; `frame` is Q, material to world.
ConstitutiveStep constitutive_step(const Matter& matter, const Mat3& F_trial, const Mat3& frame,
                                   const PlasticHistory& history);

/// C : E : E / 2 of laws that are linear in strain [J/m^3 of rest volume].
double elastic_energy_density(const Matter& matter, const Mat3& strain);

} // namespace wry::mpm
