#include <cmath>

#include <gtest/gtest.h>

#include "tests/render/pictures_support.h"
#include "tests/render/shapes_support.h"

namespace wry::render {
namespace {

/// Light sent to the eye by the middle of a ball, integrated over far lights from everywhere.
double reflected_of_all_directions(const Look& look) {
  const MeshScene ball = make_mesh_scene(testing::sphere(Vec3(0, 0, 0), 1, 256, 512), "ball", "");
  RenderPlan plan = testing::white_furnace(ball, look);
  plan.rig.sky.setZero();
  plan.rig.given_bounce.setZero();
  plan.camera.azimuth_degrees = 0;
  plan.camera.elevation_degrees = 0;
  plan.size = {65, 65};
  // Directions by rings about the view axis, midpoint in cos^2 so that each has the same share of a matt surface's
  // light.
  double sum = 0.0;
  constexpr int RINGS = 32;
  for (int ring = 0; ring < RINGS; ++ring) {
    const double cosine = std::sqrt((ring + 0.5) / RINGS);
    Light light;
    light.angular_radius_degrees = 0;
    light.elevation_degrees = 0;
    light.azimuth_degrees = std::acos(cosine) * 180.0 / 3.14159265358979;
    light.radiance.setConstant(static_cast<float>(1.0 / cosine));
    plan.rig.lights = {light};
    Result<Renderer> renderer = Renderer::create(plan, ball.scene);
    EXPECT_TRUE(renderer.ok());
    const Result<LinearImage> image = renderer->draw_linear(ball.frame, {});
    EXPECT_TRUE(image.ok());
    sum += static_cast<double>(image->at(32, 32)[0]) / RINGS;
  }
  return sum;
}

TEST(Material, SendsBackAllLightOfDistantLightsAndNoMore) {
  EXPECT_NEAR(reflected_of_all_directions(testing::white(1.F, 0.F)), 1.0, 0.02);
  EXPECT_NEAR(reflected_of_all_directions(testing::white(0.6F, 1.F)), 1.0, 0.03);
}

} // namespace
} // namespace wry::render
