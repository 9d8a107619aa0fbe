#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/mpm/matter/mandel.h"

/// Orthotropic elasticity by named axes, as 6 x 6 Mandel matrices.
namespace wry::mpm {

/// Lamé's two constants [Pa].
struct LameModuli {
  double lambda = 0.0;
  double mu = 0.0;
};
LameModuli lame_moduli(double youngs_modulus, double poisson_ratio);

/// lambda I (x) I + 2 mu Id
Mat6 isotropic_stiffness(const LameModuli& moduli);

/// An orthotropic elastic law in the axes of the material. nu_ij is the contraction along j for an extension along i.
struct OrthotropicElasticity {
  Vec3 youngs_modulus = Vec3::Ones(); ///< along x, y, z [Pa]
  double nu_yz = 0.0, nu_xz = 0.0, nu_xy = 0.0;
  std::optional<Vec3> shear_modulus; ///< of the planes yz, zx, xy [Pa]; absent: Li and Barbic's, default_shear_moduli
};

/// sqrt(E_i E_j) / (2 (1 + sqrt(nu_ij nu_ji))) with the root signed like nu_ij (Li and Barbic), planes yz, zx, xy.
Vec3 default_shear_moduli(const OrthotropicElasticity& elasticity);

/// The inverse of the stiffness. Shears on the diagonal are 1 / (2 mu).
Mat6 orthotropic_compliance(const OrthotropicElasticity& elasticity);
/// Of a law without violations.
Mat6 orthotropic_stiffness(const OrthotropicElasticity& elasticity);

/// One reason why a law has no positive energy.
struct StiffnessViolation {
  std::string inequality; ///< "|nu_xz| < sqrt(E_x / E_z)"
  std::string ratio;      ///< the value at fault: "xz"; empty: a modulus, or all three ratios together
  double left = 0.0, right = 0.0;
  /// Where the ratio at fault may lie, the others held; of all three together: of each that can mend it alone.
  std::string admissible;
};

/// Whether the compliance is positive definite, and if not, why: in the order moduli, xy, yz, xz, all three together.
struct StiffnessCheck {
  std::vector<StiffnessViolation> violations;
  /// Least eigenvalue of S_ij sqrt(E_i E_j) of the normal part; not a number when a modulus is not positive.
  double least_scaled_eigenvalue = 0.0;
  bool positive_definite() const { return violations.empty(); }
};
StiffnessCheck check_orthotropic(const OrthotropicElasticity& elasticity);

/// max over unit n of the largest eigenvalue of n . C . n [Pa]: density times the square of the fastest wave.
double stiffest_wave_modulus(const Mat6& stiffness);

} // namespace wry::mpm
