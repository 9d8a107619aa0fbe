#include "tests/fem/solid_support.h"

#include <cmath>
#include <cstring>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace wry::fem::test {

std::shared_ptr<const geometry::TetMesh> box_mesh(const Vec3& corner, const Vec3& size, int nx, int ny, int nz) {
  std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>();
  const auto number = [&](int i, int j, int k) { return (i * (ny + 1) + j) * (nz + 1) + k; };
  mesh->vertices.resize((nx + 1) * (ny + 1) * (nz + 1), 3);
  for (int i = 0; i <= nx; ++i) {
    for (int j = 0; j <= ny; ++j) {
      for (int k = 0; k <= nz; ++k)
        mesh->vertices.row(number(i, j, k)) =
            (corner + Vec3(size[0] * i / nx, size[1] * j / ny, size[2] * k / nz)).transpose();
    }
  }
  constexpr int ORDERS[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  mesh->tets.resize(6 * nx * ny * nz, 4);
  int tet = 0;
  for (int i = 0; i < nx; ++i) {
    for (int j = 0; j < ny; ++j) {
      for (int k = 0; k < nz; ++k) {
        for (const auto& order : ORDERS) {
          int at[3] = {i, j, k};
          int corners[4] = {number(i, j, k), 0, 0, 0};
          for (int step = 0; step < 3; ++step) {
            ++at[order[step]];
            corners[step + 1] = number(at[0], at[1], at[2]);
          }
          for (int c = 0; c < 4; ++c)
            mesh->tets(tet, c) = corners[c];
          const Vec3 a = mesh->vertices.row(corners[1]) - mesh->vertices.row(corners[0]);
          const Vec3 b = mesh->vertices.row(corners[2]) - mesh->vertices.row(corners[0]);
          const Vec3 c = mesh->vertices.row(corners[3]) - mesh->vertices.row(corners[0]);
          if (a.cross(b).dot(c) < 0.0)
            std::swap(mesh->tets(tet, 2), mesh->tets(tet, 3));
          ++tet;
        }
      }
    }
  }
  return mesh;
}

FemBody make_body(std::shared_ptr<const geometry::TetMesh> mesh, ElasticModel model, double youngs_modulus,
                  double poisson_ratio) {
  FemBody body;
  body.name = "body";
  body.mesh = std::move(mesh);
  body.material.name = "material";
  body.material.model = model;
  body.material.youngs_modulus = youngs_modulus;
  body.material.poisson_ratio = poisson_ratio;
  return body;
}

std::vector<std::int32_t> vertices_at(const geometry::TetMesh& mesh, int axis, double value) {
  std::vector<std::int32_t> vertices;
  for (Eigen::Index i = 0; i < mesh.vertices.rows(); ++i) {
    if (std::abs(mesh.vertices(i, axis) - value) < 1e-9)
      vertices.push_back(static_cast<std::int32_t>(i));
  }
  return vertices;
}

FemPlan plan_of(FemBody body) {
  FemPlan plan;
  plan.bodies.push_back(std::move(body));
  plan.gravity.setZero();
  return plan;
}

std::unique_ptr<FemSimulation> simulate(const FemPlan& plan, int threads, Isa isa) {
  Result<std::unique_ptr<FemSimulation>> simulation = FemSimulation::create(plan, threads, isa);
  if (!simulation) {
    ADD_FAILURE() << simulation.error().message;
    return nullptr;
  }
  return std::move(simulation).value();
}

int run_until(FemSimulation& simulation, double end) {
  int steps = 0;
  while (simulation.time() < end) {
    const Result<StepStats> stats = simulation.step(end);
    if (!stats) {
      ADD_FAILURE() << stats.error().message;
      return 0;
    }
    ++steps;
  }
  return steps;
}

Eigen::MatrixXd channel_of(const FemSimulation& simulation, const std::string& name, int body) {
  const Frame frame = simulation.snapshot(1);
  const Channel* channel = find_channel(frame.bodies[body], name);
  if (channel == nullptr) {
    ADD_FAILURE() << "no channel " << name;
    return {};
  }
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Index rows = static_cast<Eigen::Index>(channel->values.size()) / channel->components;
  return Eigen::Map<const RowMajor>(channel->values.data(), rows, channel->components);
}

Points positions_of(const FemSimulation& simulation, int body) {
  return channel_of(simulation, "position", body);
}

std::uint64_t hash_of(const StateArchive& archive) {
  std::uint64_t hash = 1469598103934665603ull;
  for (const NamedArray& array : archive) {
    for (const double value : array.values) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &value, sizeof bits);
      hash = (hash ^ bits) * 1099511628211ull;
      hash ^= hash >> 29;
    }
  }
  return hash;
}

} // namespace wry::fem::test
