#pragma once

#include <optional>
#include <string_view>

#include "sim/mpm/material.h"
#include "sim/mpm/matter/anisotropic_maps.h"

/// What matter of the material point method is made of, compiled: every law as numbers in the axes of the material.
namespace wry::mpm {

/// Whether the stress is exactly conjugate to the strain measure.
enum class StressConjugacy {
  exact,
  literal, ///< the text of the paper: T rotated back; for comparison
};

struct SnowLimits {
  double compression = 0.025; ///< theta_c
  double stretch = 0.0075;    ///< theta_s
  double hardening = 10.0;    ///< xi
};

/// phi(q) = h0 + (h1 q - h3) exp(-h2 q) [degrees], q the plastic flow so far.
struct FrictionHardening {
  double h0 = 35.0, h1 = 0.0, h2 = 0.0, h3 = 0.0;
  bool is_constant() const { return h1 == 0.0 && h3 == 0.0; }
};

struct YieldRule {
  Plasticity law = Plasticity::none;
  SnowLimits snow;
  FrictionHardening friction;
  Flow flow = Flow::fictitious;
  bool volume_correction = false; ///< v_c of Tampubolon et al. 2017; Drucker-Prager only
  double shear_limit = 0.0025;    ///< k, fictitious strain
};

/// An elastoplastic law. Isotropic matter has identity maps that nothing reads.
struct Matter {
  Elasticity elasticity = Elasticity::hencky;
  StrainMeasure measure = StrainMeasure::hencky; ///< never automatic
  FrameMode frame = FrameMode::polar;            ///< never automatic
  StressConjugacy conjugacy = StressConjugacy::exact;
  YieldRule plasticity;
  bool isotropic = true;
  Mat6 stiffness = Mat6::Zero(); ///< C: of the real material
  LameModuli fictitious;         ///< C-bar: of the isotropic solid that stands for it; the material's own if isotropic
  AnisotropicMaps maps;
};

/// Whether the elastic stress is C : strain whatever the maps: linear in the strain measure.
bool is_linear_in_strain(Elasticity elasticity);
/// Whether a step of this matter needs A^E and its inverses: anisotropic, and plastic or not linear in strain.
bool needs_maps(const Matter& matter);

/// What a particle remembers of its plastic flow; unused ones keep these values and need no memory.
struct PlasticHistory {
  double volume_ratio = 1.0;      ///< J_p: snow
  double flow = 0.0;              ///< q: Drucker-Prager with hardening
  double volume_correction = 0.0; ///< v_c: Drucker-Prager with volume correction
};

std::string_view elasticity_name(Elasticity elasticity);
std::string_view plastic_law_name(Plasticity law);

} // namespace wry::mpm
