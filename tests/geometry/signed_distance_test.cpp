#include "sim/geometry/signed_distance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "sim/geometry/closest_point_tree.h"
#include "sim/geometry/primitives.h"
#include "sim/geometry/signed_distance_volume.h"
#include "tests/geometry/volumes_support.h"

namespace wry::geometry {
namespace {

/// Points of a small deterministic spread over [-1, 1]^3.
std::vector<Vec3> spread(int count) {
  std::vector<Vec3> points;
  for (int i = 1; i <= count; ++i)
    points.emplace_back(std::fmod(i * 0.754877666, 1.0) * 2 - 1, std::fmod(i * 0.569840290, 1.0) * 2 - 1,
                        std::fmod(i * 0.362316235, 1.0) * 2 - 1);
  return points;
}

class SignedDistanceField : public testing::Test {
protected:
  void SetUp() override {
    const Result<SignedDistance> probe = SignedDistance::from_surface(*make_sphere(1, 0.5), 0.2);
    if (!probe && probe.error().code == ErrorCode::unavailable)
      GTEST_SKIP() << probe.error().message;
  }
};

TEST_F(SignedDistanceField, IsThatOfASphere) {
  const Result<SignedDistance> field = SignedDistance::from_surface(*make_sphere(0.8, 0.02), 0.02);
  ASSERT_TRUE(field.ok());
  for (const Vec3& x : spread(2000)) {
    const double exact = x.norm() - 0.8;
    if (exact > 0.06 || x.norm() < 0.03)
      continue;
    EXPECT_NEAR(field->value(x), exact, 0.0015) << x.transpose();
    EXPECT_EQ(field->is_inside(x), exact < 0) << x.transpose();
    EXPECT_NEAR((field->gradient(x) - x.normalized()).norm(), 0, 0.06) << x.transpose();
  }
}

TEST_F(SignedDistanceField, CountsOverlapsOnceAndHollowsAsOutside) {
  SurfaceMesh two = *make_sphere(0.5, 0.05);
  const Eigen::Index vertices = two.vertices.rows();
  const Eigen::Index triangles = two.triangles.rows();
  two.vertices.conservativeResize(2 * vertices, 3);
  two.triangles.conservativeResize(2 * triangles, 3);
  two.vertices.bottomRows(vertices) = two.vertices.topRows(vertices).rowwise() + Eigen::RowVector3d(0.4, 0, 0);
  two.triangles.bottomRows(triangles) = two.triangles.topRows(triangles).array() + static_cast<int>(vertices);
  const Result<SignedDistance> field = SignedDistance::from_surface(two, 0.02);
  ASSERT_TRUE(field.ok());
  EXPECT_TRUE(field->is_inside({0.2, 0, 0}));
  const double lens = M_PI / 12 * (4 * 0.5 + 0.4) * (2 * 0.5 - 0.4) * (2 * 0.5 - 0.4);
  const double volume =
      volume_between([&](const Vec3& x) { return field->value(x); }, {field->low(), field->high()}, -10, 0, 0.02);
  EXPECT_NEAR(volume, 2 * 4 * M_PI / 3 * 0.125 - lens, 0.01);
}

TEST_F(SignedDistanceField, RefusesOpenEmptyAndOversizedInput) {
  const SurfaceMesh sphere = *make_sphere(1, 0.2);
  const auto open = SignedDistance::from_surface(without_triangles(sphere, 3), 0.1);
  ASSERT_FALSE(open.ok());
  EXPECT_EQ(open.error().code, ErrorCode::bad_input);
  EXPECT_FALSE(SignedDistance::from_surface(SurfaceMesh{}, 0.1).ok());
  EXPECT_FALSE(SignedDistance::from_surface(sphere, 0.0).ok());
  EXPECT_FALSE(SignedDistance::from_surface(sphere, -1.0).ok());
  const auto huge = SignedDistance::from_surface(sphere, 1e-4);
  ASSERT_FALSE(huge.ok());
  EXPECT_THAT(huge.error().message, testing::HasSubstr("voxels"));
  SurfaceMesh broken = sphere;
  broken.vertices(0, 0) = std::nan("");
  EXPECT_FALSE(SignedDistance::from_surface(broken, 0.1).ok());
}

TEST_F(SignedDistanceField, HasTheSameBitsOnAnyNumberOfThreads) {
  const SurfaceMesh bunny = bunny_surface();
  std::vector<double> first;
  for (const std::size_t threads : {1U, 2U, 5U}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const Result<SignedDistance> field = SignedDistance::from_surface(bunny, 0.02);
    ASSERT_TRUE(field.ok());
    std::vector<double> values;
    for (const Vec3& x : spread(5000))
      values.push_back(field->value(x));
    if (first.empty())
      first = values;
    EXPECT_EQ(values, first);
  }
}

TEST(ClosestPointTree, FindsWhatABruteSearchFinds) {
  const SurfaceMesh torus = *make_torus(0.6, 0.25, Axis::y, 0.1);
  const ClosestPointTree tree(torus);
  for (const Vec3& x : spread(300)) {
    double best = 1e9;
    for (Eigen::Index t = 0; t < torus.triangles.rows(); ++t) {
      SurfaceMesh one{torus.vertices, torus.triangles.row(t), {}};
      best = std::min(best, ClosestPointTree(one).closest(x).distance);
    }
    EXPECT_NEAR(tree.closest(x).distance, best, 1e-14);
  }
}

TEST(ClosestPointTree, ABoundedSearchFindsTheSamePointOrNothing) {
  const ClosestPointTree tree(*make_torus(0.6, 0.25, Axis::y, 0.1));
  for (const Vec3& x : spread(2000)) {
    const ClosestPoint all = tree.closest(x);
    const ClosestPoint near = tree.closest_within(x, 1.000001 * all.distance);
    EXPECT_EQ(near.triangle, all.triangle);
    EXPECT_EQ(near.point, all.point);
    EXPECT_EQ(tree.closest_within(x, 0.999999 * all.distance).triangle, -1);
  }
}

TEST(ClosestPointTree, TellsInsideAtFacesEdgesAndCorners) {
  const ClosestPointTree tree(*make_block_surface(box_block({2, 2, 2}), 2.0));
  for (const Vec3& x : spread(2000)) {
    const Vec3 y = 2 * x;
    const Vec3 q = y.cwiseAbs() - Vec3::Ones();
    const double exact = q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
    EXPECT_NEAR(tree.signed_distance(y), exact, 1e-12) << y.transpose();
  }
}

TEST(VolumeBetween, ConvergesToThatOfASphericalShell) {
  const auto distance = [](const Vec3& x) { return x.norm() - 0.9; };
  const double exact = 4 * M_PI / 3 * (std::pow(0.9, 3) - std::pow(0.7, 3));
  const Bounds bounds{{-1, -1, -1}, {1, 1, 1}};
  EXPECT_NEAR(volume_between(distance, bounds, -0.2, 0, 0.1), exact, 0.005 * exact);
  EXPECT_NEAR(volume_between(distance, bounds, -0.2, 0, 0.02), exact, 0.0002 * exact);
}

} // namespace
} // namespace wry::geometry
