#pragma once

#include <memory>
#include <string>

#include "sim/fem/fem_simulation.h"

namespace wry::fem::test {

/// A box of cells, six tets each (Kuhn), from `corner` with edges `size`.
std::shared_ptr<const geometry::TetMesh> box_mesh(const Vec3& corner, const Vec3& size, int nx, int ny, int nz);

/// A body of that mesh and a material with the given model.
FemBody make_body(std::shared_ptr<const geometry::TetMesh> mesh, ElasticModel model, double youngs_modulus,
                  double poisson_ratio);

/// Vertices whose coordinate `axis` lies within 1e-9 of `value`.
std::vector<std::int32_t> vertices_at(const geometry::TetMesh& mesh, int axis, double value);

/// A plan of one body without gravity.
FemPlan plan_of(FemBody body);

/// The simulation of a plan, or a null pointer and a test failure.
std::unique_ptr<FemSimulation> simulate(const FemPlan& plan, int threads = 1, Isa isa = native_isa());

/// Steps until `end`; a test failure and a zero on error. Returns the number of steps.
int run_until(FemSimulation& simulation, double end);

/// The positions of a body as they are now, a row per vertex.
Points positions_of(const FemSimulation& simulation, int body = 0);
/// A channel of a body as rows.
Eigen::MatrixXd channel_of(const FemSimulation& simulation, const std::string& name, int body = 0);

/// All bits of an archive, for comparisons.
std::uint64_t hash_of(const StateArchive& archive);

} // namespace wry::fem::test
