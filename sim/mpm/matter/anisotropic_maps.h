#pragma once

#include "sim/base/result.h"
#include "sim/mpm/matter/elasticity_tensor.h"

/// The maps between the material's own stress and strain and those of a fictitious isotropic solid (Schreck and Wojtan
/// 2020, section 6). 6 x 6 Mandel matrices in the axes of the material.
namespace wry::mpm {

/// What a particle needs at run time.
struct AnisotropicMaps {
  Mat6 strain = Mat6::Identity();         ///< A^E: real -> fictitious strain
  Mat6 strain_inverse = Mat6::Identity(); ///< fictitious -> real strain
  Mat6 stress_inverse = Mat6::Identity(); ///< (A^sigma)^-1: fictitious -> real stress
};

/// A^sigma of plastic scales a along x, y, z: S -> diag(a) S diag(a).
Mat6 stress_map(const Vec3& plastic_scale);

/// Maps with A^E = C_fictitious^-1 A^sigma C.
AnisotropicMaps make_maps(const Mat6& stiffness, const LameModuli& fictitious, const Mat6& stress_map);

/// The isotropic law nearest to A^sigma C in Frobenius norm: 3 kappa is a third of the sum of its normal block, 2 mu a
/// fifth of the trace less that. Errors: a Poisson ratio outside (-1, 1/2), with its value.
Result<LameModuli> fit_isotropic(const Mat6& stiffness, const Mat6& stress_map);

/// Refuses a general A^sigma that is singular, turns matter inside out (det <= 0) or has a condition number of 1e4 or
/// more.
Status check_stress_map(const Mat6& stress_map);

/// A user's own A^E: refuses one for which the elastic tangent (A^sigma)^-1 C_fictitious A^E is not positive definite.
/// The value is that tangent's relative asymmetry: above 1e-6 elastic work is not conserved, which deserves a warning.
Result<double> check_strain_map(const Mat6& strain_map, const LameModuli& fictitious, const Mat6& stress_map);

/// Under hydrostatic pressure alone the fictitious stress has the deviator dev(D^2): with |dev D^2| / tr D^2 >= alpha
/// it yields and the material flows with nothing pushing it sideways. The least friction angle that carries it
/// [degrees].
double least_friction_angle(const Vec3& plastic_scale);
/// The same of any A^sigma.
double least_friction_angle(const Mat6& stress_map);

/// Drucker and Prager's alpha of a friction angle [degrees]: sqrt(2/3) 2 sin / (3 - sin).
double drucker_prager_alpha(double friction_angle);

} // namespace wry::mpm
