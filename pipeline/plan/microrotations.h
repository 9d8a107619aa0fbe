#pragma once

#include <string>

#include "shots/shot.h"

namespace wry::pipeline {

/// What becomes of a body's microrotations, and why; for the compiler and for `wry plan`.
struct MicrorotationChoice {
  bool condensed = false;
  std::string why;
  std::string warning; ///< empty: none
};

/// Without energy of curvature and rotary inertia, microrotations are determined point by point: they minimise the
/// strain energy of the deformation there. For couple_modulus_ratio >= 1 the minimiser is the rotation of the matter
/// (Fischle and Neff 2017), and what is left is the corotated model. With a Poisson's ratio above 0 that holds only
/// while the stretches sum to less than 3 + 2 mu / lambda, so that `auto` condenses only where the ratio is not above
/// 0, and only where no view or measure reads microrotations and no drive or load turns them.
MicrorotationChoice choose_microrotations(const shots::Shot& shot, const shots::Body& body,
                                          const shots::Material& material);

} // namespace wry::pipeline
