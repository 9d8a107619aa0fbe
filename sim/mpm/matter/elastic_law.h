#pragma once

#include "sim/mpm/matter/matter.h"

namespace wry::mpm {

/// An isotropic elastic law on principal strains, as scalars: what the fictitious solid answers.
struct ElasticLaw {
  Elasticity elasticity;
  /// The principal stresses conjugate to the principal strains e of that measure, before any hardening.
  Vec3 (*stress)(const Vec3& e, StrainMeasure measure, const LameModuli& moduli);
};

/// One entry per Elasticity.
const ElasticLaw& elastic_law(Elasticity elasticity);

/// The principal stretches of principal strains.
Vec3 stretches_of(const Vec3& strains, StrainMeasure measure);
Vec3 strains_of(const Vec3& stretches, StrainMeasure measure);

} // namespace wry::mpm
