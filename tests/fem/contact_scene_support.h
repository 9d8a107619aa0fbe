#pragma once

#include <string>

#include "tests/fem/solid_support.h"

namespace wry::fem::test {

/// A neo-Hookean box of cells.
FemBody box_body(const std::string& name, const Vec3& corner, const Vec3& size, const Eigen::Vector3i& cells,
                 double youngs_modulus = 1e5);
/// One tet.
FemBody tet_body(const std::string& name, const Eigen::Matrix<double, 4, 3>& corners, double youngs_modulus = 1e6);

/// The first intersection of the bodies as they are now, by the exact test; empty when there is none.
std::string find_intersection(const FemPlan& plan, const FemSimulation& simulation);

/// How a simulation went.
struct Outcome {
  double reached = 0.0; ///< [s]
  int steps = 0;
  int iterations = 0; ///< of Newton
  int cuts = 0;
  double worst_residual = 0.0; ///< [N s]
  int contacts = 0;            ///< the most at the end of a step
  double least_gap = 1e300;    ///< over all steps [m]
  std::string error;           ///< why it stopped early
  std::string intersection;    ///< must be empty, whatever the error
};
/// Steps until `end` or an error, looking for intersections after every step. With a name it is a case of the extreme
/// suite.
Outcome run_and_check(const FemPlan& plan, double end, const std::string& name = "");

/// Fixes all vertices of a body.
void fix_body(FemPlan& plan, int body);

/// Sum of mass x velocity of all bodies [N s].
Vec3 momentum_of(const FemPlan& plan, const FemSimulation& simulation);
/// Mass-weighted mean of a body's velocity [m/s].
Vec3 velocity_of(const FemPlan& plan, const FemSimulation& simulation, int body);

} // namespace wry::fem::test
