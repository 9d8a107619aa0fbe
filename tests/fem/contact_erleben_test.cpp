#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

#include "tests/fem/contact_scene_support.h"

namespace wry::fem {
namespace {

using namespace test;

// Degenerate meetings after Erleben 2018 (Methodology for assessing mesh-based contact point methods): exactly aligned
// corners, edges and faces, spikes and cracks, on which contact normals are not defined.

using Corners = Eigen::Matrix<double, 4, 3>;

Corners spike(const Vec3& tip, const Vec3& way, double width) {
  const Vec3 across = std::abs(way.y()) > std::abs(way.x()) ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 other = way.cross(across).normalized();
  Corners corners;
  corners.row(0) = tip;
  corners.row(1) = tip + way + width * across;
  corners.row(2) = tip + way - 0.5 * width * across + 0.866 * width * other;
  corners.row(3) = tip + way - 0.5 * width * across - 0.866 * width * other;
  return corners;
}

/// A roof with its ridge along z at `height`, or turned upside down, a ridge below.
FemBody wedge(const std::string& name, const Vec3& ridge, double height, double half_width) {
  std::shared_ptr<geometry::TetMesh> mesh =
      std::make_shared<geometry::TetMesh>(*box_mesh(Vec3(-1, 0, -0.5), Vec3(2, 1, 1), 2, 1, 2));
  for (Eigen::Index i = 0; i < mesh->vertices.rows(); ++i) {
    const double up = mesh->vertices(i, 1);
    const Vec3 at(mesh->vertices(i, 0) * half_width * (1.0 - 0.98 * up), (up - 1.0) * height,
                  mesh->vertices(i, 2) * 0.2);
    mesh->vertices.row(i) = (ridge + at).transpose();
  }
  for (Eigen::Index t = 0; t < mesh->tets.rows(); ++t) {
    const Vec3 a = mesh->vertices.row(mesh->tets(t, 1)) - mesh->vertices.row(mesh->tets(t, 0));
    const Vec3 b = mesh->vertices.row(mesh->tets(t, 2)) - mesh->vertices.row(mesh->tets(t, 0));
    const Vec3 c = mesh->vertices.row(mesh->tets(t, 3)) - mesh->vertices.row(mesh->tets(t, 0));
    if (a.cross(b).dot(c) < 0.0)
      std::swap(mesh->tets(t, 2), mesh->tets(t, 3));
  }
  FemBody body = make_body(mesh, ElasticModel::neo_hookean, 1e6, 0.3);
  body.name = name;
  return body;
}

struct Scene {
  const char* name;
  std::vector<FemBody> bodies; ///< the last one moves
};

std::vector<Scene> scenes() {
  const Vec3 down(0, -0.1, 0);
  const Vec3 up(0, 0.1, 0);
  const auto cube = [](const char* name, const Vec3& corner, int cells = 1) {
    return box_body(name, corner, Vec3(0.1, 0.1, 0.1), {cells, cells, cells}, 1e6);
  };
  return {
      {"spike on spike",
       {tet_body("below", spike(Vec3(0, 0, 0), down, 0.03)), tet_body("above", spike(Vec3(0, 0.01, 0), up, 0.03))}},
      {"spike on a face",
       {cube("below", Vec3(-0.033, -0.1, -0.041)), tet_body("above", spike(Vec3(0, 0.01, 0), up, 0.03))}},
      {"spike on an edge inside a face",
       {cube("below", Vec3(-0.05, -0.1, -0.05), 2), tet_body("above", spike(Vec3(0, 0.01, 0), up, 0.03))}},
      {"spike in a crack",
       {cube("left", Vec3(-0.102, -0.1, -0.05)), cube("right", Vec3(0.002, -0.1, -0.05)),
        tet_body("above", spike(Vec3(0, 0.01, 0), up, 0.03))}},
      {"wedge on wedge", {wedge("below", Vec3(0, 0, 0), 0.1, 0.05), wedge("above", Vec3(0, 0.11, 0), 0.1, 0.05)}},
      {"spike on a wedge",
       {wedge("below", Vec3(0, 0, 0), 0.1, 0.05), tet_body("above", spike(Vec3(0, 0.01, 0), up, 0.03))}},
      {"cube on a cube, aligned", {cube("below", Vec3(0, 0, 0)), cube("above", Vec3(0, 0.11, 0))}},
      {"cube over a cliff's edge", {cube("below", Vec3(0, 0, 0)), cube("above", Vec3(0.05, 0.11, 0))}},
      {"cube on the edge between two cubes",
       {cube("left", Vec3(-0.101, 0, 0)), cube("right", Vec3(0.001, 0, 0)), cube("above", Vec3(-0.05, 0.11, 0))}},
      {"corner on a corner", {cube("below", Vec3(0, 0, 0)), cube("above", Vec3(0.1, 0.11, 0.1))}},
  };
}

TEST(ErlebenScenes, AllRunThroughWithoutIntersecting) {
  for (const Scene& scene : scenes()) {
    FemPlan plan;
    plan.bodies = scene.bodies;
    plan.bodies.back().initial_velocity = Vec3(0, -0.5, 0);
    for (int i = 0; i + 1 < static_cast<int>(plan.bodies.size()); ++i)
      fix_body(plan, i);
    plan.contact = ContactOptions{true, true, {0.3, 0.3}, {}};
    plan.settings.contact_distance = 2e-3;
    const Outcome outcome = run_and_check(plan, 0.2, scene.name);
    EXPECT_EQ(outcome.error, "") << scene.name;
    EXPECT_EQ(outcome.intersection, "") << scene.name;
    EXPECT_GT(outcome.contacts, 0) << scene.name;
    std::printf("%-36s %3d steps, at most %3d contacts, least gap %.2g m\n", scene.name, outcome.steps,
                outcome.contacts, outcome.least_gap);
  }
}

} // namespace
} // namespace wry::fem
