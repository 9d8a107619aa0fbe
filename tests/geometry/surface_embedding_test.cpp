#include "sim/geometry/surface_embedding.h"

#include <cmath>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "sim/geometry/primitives.h"
#include "sim/geometry/shell_extrusion.h"
#include "tests/geometry/volumes_support.h"

namespace wry::geometry {
namespace {

struct Carried {
  SurfaceMesh surface = *make_sphere(0.5, 0.03);
  ShellMesh shell;
  Carried() {
    ShellSettings settings;
    settings.thickness = 0.05;
    settings.edge = 0.1;
    shell = *extrude_shell(surface, settings);
  }
};

/// Bends the axis y into a circle of radius 2.
Vec3 bend(const Vec3& x) {
  const double angle = x.y() / 2;
  return {2 - (2 - x.x()) * std::cos(angle), (2 - x.x()) * std::sin(angle), x.z()};
}

template <class Map> Points mapped(const Points& points, const Map& map) {
  Points result(points.rows(), 3);
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    result.row(i) = map(Vec3(points.row(i).transpose())).transpose();
  return result;
}

TEST(SurfaceEmbedding, IsExactForAffineDeformations) {
  const Carried carried;
  const SurfaceEmbedding embedding = SurfaceEmbedding::make(carried.shell.mesh, carried.surface.vertices);
  const Threads threads(1);
  EXPECT_LT((embedding.deform(carried.shell.mesh.vertices, threads) - carried.surface.vertices).cwiseAbs().maxCoeff(),
            1e-13);
  const Mat3 stretch = Vec3(1.3, 0.7, 1.1).asDiagonal() * Eigen::AngleAxisd(1.0, Vec3(1, 2, 3).normalized()).matrix();
  const auto affine = [&](const Vec3& x) { return Vec3(stretch * x + Vec3(3, -1, 2)); };
  const Points moved = embedding.deform(mapped(carried.shell.mesh.vertices, affine), threads);
  EXPECT_LT((moved - mapped(carried.surface.vertices, affine)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(SurfaceEmbedding, FollowsABendBetterThanFlatTetsDo) {
  const Carried carried;
  const SurfaceEmbedding embedding = SurfaceEmbedding::make(carried.shell.mesh, carried.surface.vertices);
  const Points positions = mapped(carried.shell.mesh.vertices, bend);
  const Points wanted = mapped(carried.surface.vertices, bend);
  const Points carried_points = embedding.deform(positions, Threads(1));
  Points flat(wanted.rows(), 3);
  for (Eigen::Index i = 0; i < wanted.rows(); ++i) {
    flat.row(i).setZero();
    for (int k = 0; k < 4; ++k)
      flat.row(i) += embedding.weights(i)[k] * positions.row(carried.shell.mesh.tets(embedding.tet(i), k));
  }
  const double error = (carried_points - wanted).rowwise().norm().mean();
  const double flat_error = (flat - wanted).rowwise().norm().mean();
  EXPECT_GT(flat_error, 1e-5);
  EXPECT_LT(error, 0.5 * flat_error);
}

TEST(SurfaceEmbedding, TiesPointsToTetsThatNearlyHoldThem) {
  const SurfaceMesh bunny = bunny_surface();
  ShellSettings settings;
  settings.thickness = 0.02;
  settings.edge = 0.06;
  const Result<ShellMesh> shell = extrude_shell(bunny, settings);
  ASSERT_TRUE(shell.ok());
  const SurfaceEmbedding embedding = SurfaceEmbedding::make(shell->mesh, bunny.vertices);
  for (Eigen::Index i = 0; i < embedding.points(); ++i)
    ASSERT_GT(embedding.weights(i).minCoeff(), -1.5) << bunny.vertices.row(i);
}

TEST(SurfaceEmbedding, ValuesBetweenCornersAreLinear) {
  const Carried carried;
  const Points& vertices = carried.shell.mesh.vertices;
  const SurfaceEmbedding embedding = SurfaceEmbedding::make(carried.shell.mesh, carried.surface.vertices);
  const auto value = [](const auto& row) { return 3 * row[0] - 2 * row[1] + row[2] + 5; };
  std::vector<double> values;
  for (Eigen::Index i = 0; i < vertices.rows(); ++i)
    values.push_back(value(vertices.row(i)));
  const std::vector<double> between = embedding.interpolate(values, 1);
  ASSERT_EQ(between.size(), static_cast<std::size_t>(carried.surface.vertices.rows()));
  for (Eigen::Index i = 0; i < carried.surface.vertices.rows(); ++i)
    EXPECT_NEAR(between[static_cast<std::size_t>(i)], value(carried.surface.vertices.row(i)), 1e-12);
}

TEST(SurfaceEmbedding, KnowsWhatLiesFarthestOutside) {
  TetMesh tet;
  tet.vertices = (Points(4, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1).finished();
  tet.tets = (Tets(1, 4) << 0, 1, 2, 3).finished();
  const Points points = (Points(3, 3) << .1, .1, .1, .2, .2, -.25, .4, .4, .3).finished();
  const SurfaceEmbedding::Farthest far = SurfaceEmbedding::make(tet, points).farthest();
  EXPECT_NEAR(far.distance, .25, 1e-12); // the third is .1/sqrt(3) outside
  EXPECT_NEAR(far.edge, std::sqrt(2.0), 1e-12);
  EXPECT_EQ(far.point.z(), -.25);
  EXPECT_EQ(SurfaceEmbedding::make(tet, points.topRows(1)).farthest().distance, 0.0);
}

TEST(SurfaceEmbedding, HasTheSameBitsOnAnyNumberOfThreads) {
  const Carried carried;
  const SurfaceEmbedding embedding = SurfaceEmbedding::make(carried.shell.mesh, carried.surface.vertices);
  const Points positions = mapped(carried.shell.mesh.vertices, bend);
  const Points one = embedding.deform(positions, Threads(1));
  EXPECT_EQ(one, embedding.deform(positions, Threads(2)));
  EXPECT_EQ(one, embedding.deform(positions, Threads(3)));
}

} // namespace
} // namespace wry::geometry
