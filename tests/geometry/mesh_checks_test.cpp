#include "sim/geometry/mesh_checks.h"

#include <cmath>
#include <limits>
#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "sim/geometry/mesh_checks_predicates.h"
#include "sim/geometry/primitives.h"

namespace wry::geometry {
namespace {

using testing::Test;

SurfaceMesh box(const Vec3& size, const Vec3& centre = Vec3::Zero(), double edge = 0.25) {
  SurfaceMesh mesh = make_block_surface(box_block(size), edge).value();
  mesh.vertices.rowwise() += centre.transpose();
  return mesh;
}

SurfaceMesh joined(const SurfaceMesh& a, const SurfaceMesh& b) {
  SurfaceMesh mesh;
  mesh.vertices.resize(a.vertices.rows() + b.vertices.rows(), 3);
  mesh.vertices << a.vertices, b.vertices;
  mesh.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
  mesh.triangles << a.triangles, b.triangles.array() + static_cast<std::int32_t>(a.vertices.rows());
  return mesh;
}

SurfaceMesh inside_out(SurfaceMesh mesh) {
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

SurfaceMesh without_triangle(const SurfaceMesh& mesh, Eigen::Index t) {
  SurfaceMesh cut = mesh;
  cut.triangles.resize(mesh.triangles.rows() - 1, 3);
  cut.triangles << mesh.triangles.topRows(t), mesh.triangles.bottomRows(mesh.triangles.rows() - t - 1);
  return cut;
}

TEST(MeshChecks, GoodMeshHasNoFlaw) {
  const MeshReport report = inspect_mesh(box({1, 1, 1}));
  EXPECT_TRUE(report.is_valid() && report.is_closed() && report.is_manifold() && report.is_oriented());
  EXPECT_NEAR(report.volume, 1, 1e-14);
  EXPECT_EQ(report.extent(), Vec3(1, 1, 1));
}

TEST(MeshChecks, HoleIsNamedWithItsPlace) {
  const SurfaceMesh whole = box({1, 1, 1}, {5, 0, 0});
  const MeshReport report = inspect_mesh(without_triangle(whole, 0));
  EXPECT_EQ(report.boundary_edges, 3);
  ASSERT_EQ(report.boundary_loops, 1);
  EXPECT_EQ(report.longest_loops[0].edges, 3);
  EXPECT_NEAR(report.longest_loops[0].length, 0.25 * (2 + std::sqrt(2.0)), 1e-12);
  const Status status = check_closed(report, "bunny.obj");
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("bunny.obj is not closed: 1 hole"), std::string::npos)
      << status.error().message;
  EXPECT_NE(status.error().message.find("(4.5, "), std::string::npos) << status.error().message;
}

TEST(MeshChecks, SeparateHolesAreSeparateLoopsLongestFirst) {
  SurfaceMesh mesh = box({1, 1, 1});
  mesh = without_triangle(without_triangle(without_triangle(mesh, 190), 1), 0);
  const MeshReport report = inspect_mesh(mesh);
  ASSERT_EQ(report.boundary_loops, 2);
  EXPECT_EQ(report.longest_loops[0].edges, 4);
  EXPECT_EQ(report.longest_loops[1].edges, 3);
}

TEST(MeshChecks, BadNumbersAndIndicesAreFound) {
  SurfaceMesh mesh = box({1, 1, 1});
  mesh.vertices(7, 1) = std::numeric_limits<double>::quiet_NaN();
  mesh.triangles(3, 0) = 100000;
  mesh.triangles(4, 0) = -1;
  mesh.triangles(5, 0) = mesh.triangles(5, 1);
  const MeshReport report = inspect_mesh(mesh);
  EXPECT_FALSE(report.is_valid());
  EXPECT_EQ(report.non_finite_vertices.examples, std::vector<std::int32_t>{7});
  EXPECT_EQ(report.bad_indices.examples, (std::vector<std::int32_t>{3, 4}));
  EXPECT_EQ(report.repeated_corners.examples, std::vector<std::int32_t>{5});
  EXPECT_FALSE(check_valid(mesh, report, "m"));
  mesh.vertices(7, 1) = 0;
  EXPECT_NE(check_valid(mesh, inspect_mesh(mesh), "m").error().message.find("triangle 3 names vertices 100000"),
            std::string::npos);
  EXPECT_FALSE(check_valid(SurfaceMesh{}, inspect_mesh(SurfaceMesh{}), "m"));
}

TEST(MeshChecks, FlatAndDuplicateTrianglesAreFound) {
  SurfaceMesh mesh = box({1, 1, 1});
  mesh.triangles.conservativeResize(mesh.triangles.rows() + 2, 3);
  mesh.triangles.bottomRows(2) << mesh.triangles(0, 2), mesh.triangles(0, 0), mesh.triangles(0, 1), 0, 1, 2;
  const MeshReport report = inspect_mesh(mesh);
  EXPECT_EQ(report.duplicate_triangles.examples,
            std::vector<std::int32_t>{static_cast<std::int32_t>(mesh.triangles.rows()) - 2});
  EXPECT_EQ(report.zero_area_triangles.examples,
            std::vector<std::int32_t>{static_cast<std::int32_t>(mesh.triangles.rows()) - 1});
  EXPECT_GT(report.nonmanifold_edges.count, 0);
  EXPECT_FALSE(check_manifold(mesh, report, "m"));
}

TEST(MeshChecks, PartsThatTouchAtAVertexAreNotManifold) {
  SurfaceMesh mesh = joined(box({1, 1, 1}), box({1, 1, 1}, {1, 1, 1}));
  EXPECT_TRUE(inspect_mesh(mesh).is_manifold());
  // Let the second box use the first one's corner.
  const auto corner_of = [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index v = begin; v < end; ++v)
      if (mesh.vertices.row(v) == Eigen::RowVector3d(0.5, 0.5, 0.5))
        return static_cast<std::int32_t>(v);
    return -1;
  };
  const Eigen::Index half = mesh.vertices.rows() / 2;
  const std::int32_t first = corner_of(0, half);
  const std::int32_t second = corner_of(half, mesh.vertices.rows());
  ASSERT_GE(first, 0);
  ASSERT_GE(second, 0);
  mesh.triangles = mesh.triangles.unaryExpr([&](std::int32_t v) { return v == second ? first : v; }).eval();
  const MeshReport report = inspect_mesh(mesh);
  EXPECT_EQ(report.nonmanifold_vertices.examples, std::vector<std::int32_t>{first});
  EXPECT_EQ(report.nonmanifold_edges.count, 0);
  EXPECT_EQ(report.components, 2);
  EXPECT_EQ(report.unused_vertices, 1);
}

TEST(OrientOutward, RepairsRandomlyFlippedTriangles) {
  const SurfaceMesh good = make_torus(1.0, 0.3, Axis::y, 0.1).value();
  SurfaceMesh mesh = good;
  std::mt19937 random(7);
  std::int64_t flipped = 0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (random() % 2 == 0)
      continue;
    std::swap(mesh.triangles(t, 1), mesh.triangles(t, 2));
    ++flipped;
  }
  EXPECT_FALSE(inspect_mesh(mesh).is_oriented());
  const Result<OrientReport> report = orient_outward(mesh);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->flipped, flipped);
  EXPECT_EQ(mesh.triangles, good.triangles);
}

TEST(OrientOutward, HollowsStayHollow) {
  const SurfaceMesh hollow = joined(box({2, 2, 2}), inside_out(box({1, 1, 1})));
  for (SurfaceMesh mesh : {hollow, inside_out(hollow)}) {
    const Result<OrientReport> report = orient_outward(mesh);
    ASSERT_TRUE(report);
    EXPECT_EQ(report->cavities, 1);
    EXPECT_EQ(mesh.triangles, hollow.triangles);
    EXPECT_NEAR(inspect_mesh(mesh).volume, 7, 1e-12);
  }
}

TEST(OrientOutward, SolidsInsideAndBesideStaySolid) {
  SurfaceMesh nested = joined(box({2, 2, 2}), box({1, 1, 1}));
  EXPECT_EQ(orient_outward(nested)->flipped, 0);
  SurfaceMesh beside = joined(box({1, 1, 1}), inside_out(box({1, 1, 1}, {3, 0, 0})));
  EXPECT_EQ(orient_outward(beside)->flipped, beside.triangles.rows() / 2);
  EXPECT_NEAR(inspect_mesh(beside).volume, 2, 1e-12);
}

TEST(OrientOutward, MoebiusStripIsRefused) {
  constexpr int N = 20;
  SurfaceMesh mesh;
  mesh.vertices.resize(2 * N, 3);
  mesh.triangles.resize(2 * N, 3);
  for (int i = 0; i < N; ++i) {
    const double angle = 2 * M_PI * i / N;
    for (int side = 0; side < 2; ++side) {
      const double r = 1 + (side - 0.5) * 0.4 * std::cos(angle / 2);
      mesh.vertices.row(2 * i + side) << r * std::cos(angle), r * std::sin(angle),
          (side - 0.5) * 0.4 * std::sin(angle / 2);
    }
    const int next = (i + 1) % N;
    const int twist = i + 1 == N;
    mesh.triangles.row(2 * i) << 2 * i, 2 * i + 1, 2 * next + twist;
    mesh.triangles.row(2 * i + 1) << 2 * i + 1, 2 * next + 1 - twist, 2 * next + twist;
  }
  const Result<OrientReport> report = orient_outward(mesh);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("one side"), std::string::npos);
}

TEST(Predicates, SignsAreExactWhereRoundingFails) {
  // Points around (0.5, 0.5) in steps of 2^-53, against the line x = y through (12, 12) and (24, 24): the differences
  // of coordinates lose those steps, so that only exact arithmetic tells the sides apart (Kettner et al. 2008).
  const double step = std::ldexp(1.0, -53);
  for (int i = 0; i < 16; ++i) {
    for (int j = 0; j < 16; ++j) {
      const double x = 0.5 + 2 * i * step;
      const double y = 0.5 + 2 * j * step;
      const int side = (i > j) - (i < j);
      EXPECT_EQ(orientation(Eigen::Vector2d(x, y), Eigen::Vector2d(12, 12), Eigen::Vector2d(24, 24)), -side)
          << i << " " << j;
      EXPECT_EQ(orientation(Vec3(x, y, 0), Vec3(12, 12, 0), Vec3(24, 24, 0), Vec3(12, 12, 1)), side) << i << " " << j;
    }
  }
}

// All pairs without a tree, in long double, away from touching.
std::size_t count_by_force(const SurfaceMesh& mesh) {
  std::size_t count = 0;
  const auto point = [&](Eigen::Index t, int k) { return Vec3(mesh.vertices.row(mesh.triangles(t, k)).transpose()); };
  const auto hits = [&](Eigen::Index s, Eigen::Index t) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = point(s, k);
      const Vec3 direction = point(s, (k + 1) % 3) - p;
      const Vec3 e1 = point(t, 1) - point(t, 0);
      const Vec3 e2 = point(t, 2) - point(t, 0);
      Mat3 matrix;
      matrix << -direction, e1, e2;
      const Vec3 x = matrix.inverse() * (p - point(t, 0));
      if (x[0] >= 0 && x[0] <= 1 && x[1] >= 0 && x[2] >= 0 && x[1] + x[2] <= 1)
        return true;
    }
    return false;
  };
  for (Eigen::Index s = 0; s < mesh.triangles.rows(); ++s)
    for (Eigen::Index t = s + 1; t < mesh.triangles.rows(); ++t)
      count += hits(s, t) || hits(t, s);
  return count;
}

TEST(SelfIntersections, RandomTrianglesAgreeWithAllPairsOnAnyNumberOfThreads) {
  SurfaceMesh soup;
  constexpr int N = 400;
  soup.vertices.resize(3 * N, 3);
  soup.triangles.resize(N, 3);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int t = 0; t < N; ++t) {
    const Vec3 centre(uniform(random), uniform(random), uniform(random));
    for (int k = 0; k < 3; ++k) {
      soup.vertices.row(3 * t + k) =
          (centre + 0.25 * Vec3(uniform(random), uniform(random), uniform(random))).transpose();
      soup.triangles(t, k) = 3 * t + k;
    }
  }
  const SelfIntersections one = find_self_intersections(soup, Threads(1), 100000);
  EXPECT_TRUE(one.complete);
  EXPECT_GT(one.pairs.size(), 50u);
  EXPECT_EQ(one.pairs.size(), count_by_force(soup));
  for (const int threads : {2, 3, 8})
    EXPECT_EQ(find_self_intersections(soup, Threads(threads), 100000).pairs, one.pairs);
  EXPECT_EQ(find_self_intersections(soup, Threads(2), 10).pairs.size(), 10u);
  EXPECT_FALSE(find_self_intersections(soup, Threads(2), 10).complete);
}

TEST(SelfIntersections, GoodMeshesHaveNone) {
  const Threads threads(2);
  EXPECT_TRUE(find_self_intersections(box({1, 1, 1}, {0.1, 0.2, 0.3}, 0.05), threads).pairs.empty());
  EXPECT_TRUE(find_self_intersections(make_sphere(1.0, 0.1).value(), threads).pairs.empty());
  EXPECT_TRUE(find_self_intersections(make_torus(1.0, 0.3, Axis::z, 0.1).value(), threads).pairs.empty());
}

TEST(SelfIntersections, CutTouchAndFoldAreFoundAndNamed) {
  const Threads threads(2);
  const SurfaceMesh cut = joined(box({1, 1, 1}), box({1, 1, 1}, {0.51, 0.52, 0.53}));
  EXPECT_GT(find_self_intersections(cut, threads).pairs.size(), 10u);
  const SurfaceMesh touching = joined(box({1, 1, 1}), box({1, 1, 1}, {1, 0, 0}));
  EXPECT_GT(find_self_intersections(touching, threads).pairs.size(), 10u);
  const SurfaceMesh apart = joined(box({1, 1, 1}), box({1, 1, 1}, {1 + 1e-12, 0, 0}));
  EXPECT_TRUE(find_self_intersections(apart, threads).pairs.empty());
  SurfaceMesh fold;
  fold.vertices.resize(4, 3);
  fold.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0.3, 0.4, 0;
  fold.triangles.resize(2, 3);
  fold.triangles << 0, 1, 2, 1, 0, 3;
  const SelfIntersections found = find_self_intersections(fold, threads);
  ASSERT_EQ(found.pairs.size(), 1u);
  EXPECT_NE(check_no_self_intersections(fold, found, "card").error().message.find("card cuts or touches itself"),
            std::string::npos);
  fold.vertices(3, 1) = -0.4;
  EXPECT_TRUE(find_self_intersections(fold, threads).pairs.empty());
}

} // namespace
} // namespace wry::geometry
