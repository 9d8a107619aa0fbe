#pragma once

#include <memory>

#include "sim/mpm/mpm_simulation.h"
#include "sim/mpm/seeding.h"

namespace wry::mpm {

/// A box of matter on a lattice.
MpmBody box_of_matter(const Vec3& low, const Vec3& high, double cell, double particles_per_cell,
                      const Material& material);

/// The column of the collapse tests: 6 x 6 x 12 cells of 1/80 m on a sticky floor, up is z.
MpmPlan column_plan(const Material& material, Precision precision);
/// Its material: Hencky, Drucker-Prager 35 degrees, E 5e4, nu .3, 1500 kg/m^3.
Material column_material();

/// Steps to a time and says in how many; ends the test program with the error's message when a step fails.
int run_to(MpmSimulation& simulation, double end);

/// Makes a simulation; ends the test program with the error's message when it cannot be.
std::unique_ptr<MpmSimulation> make(MpmPlan plan, int threads = 1);

/// Positions or velocities of a body in the order of identities.
Points channel_of(const MpmSimulation& simulation, std::size_t body, const std::string& name);

/// The value below which a share of the values is.
double quantile(Eigen::VectorXd values, double share);

} // namespace wry::mpm
