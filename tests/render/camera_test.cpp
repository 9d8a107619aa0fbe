#include "render/camera.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/render/shapes_support.h"

namespace wry::render {
namespace {

SubjectBounds bounds_of(const geometry::SurfaceMesh& mesh) {
  SubjectBounds bounds;
  bounds.include(mesh.vertices);
  return bounds;
}

/// Largest |ndc| over all vertices.
double reach_in_picture(const Camera& camera, const Points& points) {
  double reach = 0.0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Vec3 p = camera.axes.transpose() * (points.row(i).transpose() - camera.eye);
    EXPECT_LT(p.z(), -camera.near_distance);
    reach = std::max(
        {reach, std::abs(p.x() / p.z()) / camera.tan_half_width, std::abs(p.y() / p.z()) / camera.tan_half_height});
  }
  return reach;
}

TEST(Camera, FillsThePictureUpToTheMarginFromAllSides) {
  const geometry::SurfaceMesh mesh = testing::pebble(60, 60);
  const SubjectBounds bounds = bounds_of(mesh);
  for (const double elevation : {-60.0, 0.0, 14.0, 80.0}) {
    for (const double azimuth : {0.0, 30.0, 200.0}) {
      CameraPlan plan;
      plan.elevation_degrees = elevation;
      plan.azimuth_degrees = azimuth;
      const Result<Camera> camera = frame_camera(plan, Vec3::UnitY(), bounds, {1920, 1080}, Framing::still, 0.0);
      ASSERT_TRUE(camera.ok());
      const double reach = reach_in_picture(*camera, mesh.vertices);
      EXPECT_LT(reach, 0.90) << azimuth << " " << elevation;
      EXPECT_GT(reach, 0.86) << azimuth << " " << elevation;
    }
  }
}

TEST(Camera, OrbitHoldsTheSubjectOnEveryTurnAtOneDistance) {
  const geometry::SurfaceMesh mesh = testing::box(Vec3(-2, 0, -0.2), Vec3(1, 0.5, 0.3));
  const SubjectBounds bounds = bounds_of(mesh);
  double distance = -1.0;
  for (int picture = 0; picture < 96; ++picture) {
    const Result<Camera> camera =
        frame_camera(CameraPlan(), Vec3::UnitZ(), bounds, {1280, 720}, Framing::orbit, turntable_turns(picture, 96));
    ASSERT_TRUE(camera.ok());
    EXPECT_LT(reach_in_picture(*camera, mesh.vertices), 0.9);
    const double now = (camera->eye - bounds.centre()).norm();
    if (distance < 0.0)
      distance = now;
    EXPECT_NEAR(now, distance, 0.01 * distance);
  }
}

TEST(Camera, TurntableHasNoDoubledLastPicture) {
  EXPECT_EQ(turntable_turns(0, 96), 0.0);
  EXPECT_DOUBLE_EQ(turntable_turns(95, 96), 95.0 / 96.0);
}

TEST(Camera, AxesAreRightHandedAndLevel) {
  const SubjectBounds bounds = bounds_of(testing::sphere(Vec3(3, 4, 5), 2, 20, 20));
  const Result<Camera> camera = frame_camera(CameraPlan(), Vec3::UnitZ(), bounds, {640, 480}, Framing::still, 0.3);
  ASSERT_TRUE(camera.ok());
  EXPECT_NEAR((camera->axes.transpose() * camera->axes - Mat3::Identity()).norm(), 0.0, 1e-12);
  EXPECT_NEAR(camera->axes.determinant(), 1.0, 1e-12);
  EXPECT_NEAR(camera->axes.col(0).z(), 0.0, 1e-12);
  EXPECT_GT(camera->axes.col(1).z(), 0.0);
}

TEST(Camera, RollsAndLooksStraightDownWhereItsOwnUpSaysSo) {
  const SubjectBounds bounds = bounds_of(testing::pebble(20, 20));
  CameraPlan plan;
  plan.placed = PlacedCamera{Vec3(0, 0, 5), Vec3::Zero(), Vec3(1, 1, 0)};
  const Result<Camera> rolled = frame_camera(plan, Vec3::UnitY(), bounds, {640, 480}, Framing::still, 0.0);
  ASSERT_TRUE(rolled.ok());
  EXPECT_NEAR((rolled->axes.col(1) - Vec3(1, 1, 0).normalized()).norm(), 0.0, 1e-12);
  EXPECT_NEAR((rolled->axes.col(2) - Vec3::UnitZ()).norm(), 0.0, 1e-12);
  plan.placed = PlacedCamera{Vec3(0, 5, 0), Vec3::Zero(), {}};
  EXPECT_FALSE(frame_camera(plan, Vec3::UnitY(), bounds, {640, 480}, Framing::still, 0.0).ok());
  plan.placed->up = Vec3(0, 0, -1);
  const Result<Camera> down = frame_camera(plan, Vec3::UnitY(), bounds, {640, 480}, Framing::still, 0.25);
  ASSERT_TRUE(down.ok());
  EXPECT_NEAR((down->axes.col(1) - Vec3(-1, 0, 0)).norm(), 0.0, 1e-12); // a quarter turn about y takes -z to -x
}

TEST(Camera, RefusesValuesOutsideTheirLimits) {
  const SubjectBounds bounds = bounds_of(testing::sphere(Vec3(0, 0, 0), 1, 8, 8));
  const auto refused = [&](const CameraPlan& plan, const ImageSize& size) {
    return !frame_camera(plan, Vec3::UnitY(), bounds, size, Framing::still, 0.0).ok();
  };
  CameraPlan lens;
  lens.lens_mm = 2;
  EXPECT_TRUE(refused(lens, {640, 480}));
  CameraPlan steep;
  steep.elevation_degrees = 90;
  EXPECT_TRUE(refused(steep, {640, 480}));
  EXPECT_TRUE(refused(CameraPlan(), {640, 20000}));
  EXPECT_FALSE(refused(CameraPlan(), {640, 480}));
  EXPECT_FALSE(frame_camera(CameraPlan(), Vec3::UnitY(), SubjectBounds(), {640, 480}, Framing::still, 0.0).ok());
}

} // namespace
} // namespace wry::render
