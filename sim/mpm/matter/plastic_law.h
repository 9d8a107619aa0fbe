#pragma once

#include "sim/mpm/matter/matter.h"

namespace wry::mpm {

/// What a return map sees beside the strains.
struct ReturnContext {
  const Matter& matter;
  /// tr((A^E)^-1 : S) for S with the axes of the trial strain: the real volume that each fictitious principal strain
  /// takes, used by isochoric flow.
  Vec3 volume_per_strain = Vec3::Ones();
};

/// Whether a return map moved the strains; the history is updated with it.
enum class Yield { elastic, plastic };

/// A plasticity on the principal strains of the fictitious solid, as scalars.
struct PlasticLaw {
  Plasticity law;
  Yield (*project)(Vec3& strains, PlasticHistory& history, const ReturnContext& context);
};

/// One entry per Plasticity.
const PlasticLaw& plastic_law(Plasticity law);

/// Factor exp(xi (1 - J_p)) on the stress; 1 for all laws but snow.
double hardening_factor(const YieldRule& plasticity, const PlasticHistory& history);

/// alpha of Drucker-Prager after a flow of q.
double friction_alpha(const FrictionHardening& friction, double flow);

} // namespace wry::mpm
