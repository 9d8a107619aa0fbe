#pragma once

#include <optional>
#include <string_view>

#include "sim/mpm/matter/anisotropic_maps.h"

/// What matter of the material point method is made of, compiled: every law as numbers in the axes of the material.
namespace wry::mpm {

enum class Elasticity {
  linear,          ///< C : (V - I)
  hencky,          ///< C : ln V, St. Venant-Kirchhoff with logarithmic strain
  fixed_corotated, ///< Stomakhin et al. 2013
};

/// What a law calls strain, in the axes of the material.
enum class StrainMeasure {
  hencky, ///< ln V
  biot,   ///< V - I
};

enum class PlasticLaw {
  none,
  snow,           ///< stretches within [1 - compression, 1 + stretch], hardening with J_p (Stomakhin et al. 2013)
  drucker_prager, ///< Klar et al. 2016
  shear,          ///< Tresca: no two principal strains differ by more than a limit (after Ionescu et al.)
};

/// Where Drucker-Prager flow goes.
enum class PlasticFlow {
  fictitious, ///< along the deviator in fictitious space: the paper; gains volume in real space
  isochoric,  ///< keeps the real volume wherever that is possible
};

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

struct Plasticity {
  PlasticLaw law = PlasticLaw::none;
  SnowLimits snow;
  FrictionHardening friction;
  PlasticFlow flow = PlasticFlow::fictitious;
  bool volume_correction = false; ///< v_c of Tampubolon et al. 2017; Drucker-Prager only
  double shear_limit = 0.0025;    ///< k, fictitious strain
};

/// An elastoplastic law. Isotropic matter has identity maps that nothing reads.
struct Matter {
  Elasticity elasticity = Elasticity::hencky;
  StrainMeasure measure = StrainMeasure::hencky;
  StressConjugacy conjugacy = StressConjugacy::exact;
  Plasticity plasticity;
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
std::string_view plastic_law_name(PlasticLaw law);

} // namespace wry::mpm
