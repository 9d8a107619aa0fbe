#pragma once

#include <vector>

#include "sim/fem/fem_plan.h"

/// Small experiments on elements, for the tests that hold them to closed forms and for the tables of docs/elements.md.
namespace wry::fem::test {

/// A clamped bar 8 x 1 x 1 (E = 1) or plate that bends a little under its own weight.
struct Bending {
  double ratio = 0.0; ///< deflection of the tip over that of the closed form
  int unknowns = 0;
  double cpu_seconds = 0.0; ///< of the one static step
  int iterations = 0;
};

/// `cells` across the bar (Kuhn's split, cubes). The closed form is Timoshenko's, for nu = 0.
Bending bend_bar(ElasticModel model, ElementKind element, int cells, double couple_modulus_ratio,
                 LinearSolver solver = LinearSolver::cholesky);

/// A plate of length 1 and width 0.25 in square cells; the closed form is that of cylindrical bending with shear.
Bending bend_plate(ElementKind element, int cells_along, double thickness);

/// The bending stiffness of a plate of tets in plane strain over its classical one, from the curvature that a rest
/// curvature leaves. Closed form: 1 + 3 (1 - nu) (alpha + beta) (L_c / h)^2.
double plate_stiffness_ratio(ElementKind element, int cells, double poisson_ratio, double length_scale);

/// How far the nodes of a bar turn away from their neighbours, root mean square [rad], after they were set spinning at
/// random; the bar's ends are clamped.
double spin_roughness(ElementKind element, double time);

/// A bar 2 x 1 x 1, too short to coil, whose ends are turned against each other: how far its microrotations are from
/// the rotation of the matter around them, as a mean over the nodes, after each eighth of a turn.
struct Twist {
  double turns = 0.0;
  double mean_distance_deg = 0.0;
  double energy = 0.0; ///< [J]
};
std::vector<Twist> twist_bar(ElasticModel model, double poisson_ratio, double turns);

/// Energy of a bar 2 x 1 x 1 (E = 1), clamped at its ends, at growing stretches; a row per tenth. Ends early where a
/// step of a twentieth finds no solution at once.
std::vector<double> stretch_bar(ElasticModel model, double poisson_ratio, int cells, double stretch);

} // namespace wry::fem::test
