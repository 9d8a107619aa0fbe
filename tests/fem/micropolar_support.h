#pragma once

#include "tests/fem/solid_support.h"

namespace wry::fem::test {

/// A number of the specification beside what was measured: a line of micropolar_numbers.csv in the folder that the
/// environment names by WRY_EVIDENCE; nothing without.
void record_number(const std::string& what, double required, double measured);

/// A bar along z of n x n x nz cells, clamped at z = 0, with mu = 1, nu = 0, alpha = beta = gamma = 1, bent by a rest
/// curvature about x (and twisted by one about z) that grows with time; so light that steps of this length are static.
FemPlan curving_bar(double width, double length, int n, int nz, double length_scale, double bending,
                    double torsion = 0.0);

/// The rotation vector that leads from the frame at a quarter of the bar to that at three quarters, in the former, over
/// the length between: the curvature, from the microrotations on its axis [1/m].
Vec3 measured_curvature(const FemPlan& plan, const FemSimulation& simulation, double length);

/// Curvature over rest curvature of a bar 1 x 1 x 4 with n cells across (spec §11, bending size effect).
double curvature_ratio(double length_scale, int n);

/// Torsion stiffness of a cylinder of radius 1 with n cells across, over mu pi a^4/2 (spec §11).
double torsion_ratio(double length_scale, int n);

} // namespace wry::fem::test
