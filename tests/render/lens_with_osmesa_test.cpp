#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "render/environment.h"
#include "tests/render/pictures_support.h"
#include "tests/render/shapes_support.h"

namespace wry::render {
namespace {

/// A ball seen level from a fixed place, so that everything about its picture is known.
struct SeenBall {
  Vec3 centre = Vec3(0, 1, 0);
  double radius = 0.5;
  double distance = 5.0;
  MeshScene scene = make_mesh_scene(testing::sphere(centre, radius, 96, 192), "ball", "clay");
  RenderPlan plan = make_plan();

  RenderPlan make_plan() const {
    RenderPlan made = testing::small_plan(scene);
    made.size = {320, 180};
    made.ground.kind = Ground::Kind::none;
    made.camera.lens_mm = 50;
    made.camera.placed = PlacedCamera{centre + Vec3(0, 0, distance), centre, {}};
    return made;
  }

  LinearImage drawn() const {
    Result<Renderer> renderer = Renderer::create(plan, scene.scene);
    EXPECT_TRUE(renderer.ok()) << renderer.error().message;
    Result<LinearImage> image = renderer->draw_linear(scene.frame, {});
    EXPECT_TRUE(image.ok()) << image.error().message;
    return *image;
  }

  /// Sum of the coverage along the middle row, and its spread about its mean [pixels].
  static std::pair<double, double> row_of(const LinearImage& image) {
    double sum = 0.0;
    double mean = 0.0;
    double square = 0.0;
    for (int x = 0; x < image.width; ++x) {
      const double cover = static_cast<double>(image.at(x, image.height / 2)[3]);
      sum += cover;
      mean += cover * x;
      square += cover * x * x;
    }
    mean /= sum;
    return {sum, std::sqrt(square / sum - mean * mean)};
  }
  double pixels_per_metre(double at) const { return plan.size.width / (2.0 * at * 18.0 / plan.camera.lens_mm); }
};

TEST(Lens, WhatIsInFocusStaysWhatIsNotSpreadsByTheCircleOfConfusion) {
  SeenBall ball;
  ball.plan.samples = 64;
  const auto [sharp_sum, sharp_spread] = SeenBall::row_of(ball.drawn());
  ball.plan.camera.f_stop = 0.1; // an aperture of 0.5 m
  ball.plan.camera.focus_distance = ball.distance;
  const auto [focused_sum, focused_spread] = SeenBall::row_of(ball.drawn());
  EXPECT_NEAR(focused_spread, sharp_spread, 0.4);
  ball.plan.camera.focus_distance = 2.5;
  const auto [blurred_sum, blurred_spread] = SeenBall::row_of(ball.drawn());
  EXPECT_NEAR(blurred_sum, sharp_sum, 0.25 * sharp_sum); // of a row; light from other rows replaces what leaves it
  // A point spreads over a disc of this radius, whose spread along one axis is half the radius.
  const double disc = 0.25 * ball.pixels_per_metre(1.0) * std::abs(1.0 / 2.5 - 1.0 / ball.distance);
  const double expected = std::sqrt(sharp_spread * sharp_spread + 0.25 * disc * disc);
  EXPECT_GT(blurred_spread, 0.85 * expected);
  EXPECT_LT(blurred_spread, 1.15 * expected);
}

TEST(Shutter, MovingBallSpreadsOverItsPathAndStaysInTheMiddle) {
  SeenBall ball;
  ball.plan.samples = 32;
  const auto [still_sum, still_spread] = SeenBall::row_of(ball.drawn());
  constexpr double SPEED = 24.0; // [m/s]: 0.5 m while the shutter is open for half of a 24th of a second
  const auto rows = static_cast<std::size_t>(ball.scene.scene.bodies[0].rest_positions.rows());
  Channel velocity{"velocity", ChannelOn::vertex, 3, ChannelStorage::float32, std::vector<double>(3 * rows, 0.0)};
  for (std::size_t i = 0; i < rows; ++i)
    velocity.values[3 * i] = SPEED;
  ball.scene.frame.bodies[0].channels.push_back(velocity);
  ball.plan.shutter = 0.5;
  ball.plan.fps = 24.0;
  const auto [moved_sum, moved_spread] = SeenBall::row_of(ball.drawn());
  EXPECT_NEAR(moved_sum, still_sum, 0.02 * still_sum);
  const double path = 0.5 * ball.pixels_per_metre(ball.distance);
  EXPECT_NEAR(moved_spread, std::sqrt(still_spread * still_spread + path * path / 12.0), 0.05 * moved_spread);
}

TEST(Data, DistanceNormalVelocityAndBodyAgreeWithRays) {
  SeenBall ball;
  ball.plan.data = DataWanted::yes;
  const auto rows = static_cast<std::size_t>(ball.scene.scene.bodies[0].rest_positions.rows());
  Channel velocity{"velocity", ChannelOn::vertex, 3, ChannelStorage::float32, {}};
  for (std::size_t i = 0; i < rows; ++i)
    velocity.values.insert(velocity.values.end(), {1.0, -2.0, 3.0});
  ball.scene.frame.bodies[0].channels.push_back(velocity);
  Result<Renderer> renderer = Renderer::create(ball.plan, ball.scene.scene);
  ASSERT_TRUE(renderer.ok());
  const Result<DataLayers> data = renderer->draw_data(ball.scene.frame, {});
  ASSERT_TRUE(data.ok()) << data.error().message;
  const double tan_x = 18.0 / 50.0;
  const double tan_y = tan_x * 180.0 / 320.0;
  int hit = 0;
  for (int y = 0; y < data->height; ++y) {
    for (int x = 0; x < data->width; ++x) {
      const Vec3 ray((2.0 * (x + 0.5) / 320.0 - 1.0) * tan_x, (1.0 - 2.0 * (y + 0.5) / 180.0) * tan_y, -1.0);
      const double a = ray.squaredNorm();
      const double b = -ball.distance * ray.z();
      const double c = ball.distance * ball.distance - ball.radius * ball.radius;
      const double root = b * b - a * c;
      const auto i = static_cast<std::size_t>(y * data->width + x);
      if (root < -0.02) {
        EXPECT_EQ(data->body[i], 0U);
        EXPECT_EQ(data->distance[i], 0.F);
      }
      if (root < 0.05)
        continue;
      const double t = (b - std::sqrt(root)) / a;
      ASSERT_EQ(data->body[i], 1U) << x << " " << y;
      EXPECT_NEAR(data->distance[i], t, 0.004);
      const Vec3 normal = (t * ray + Vec3(0, 0, ball.distance)) / ball.radius;
      EXPECT_GT(normal.dot(Vec3(data->normal[i][0], data->normal[i][1], data->normal[i][2])), 0.998);
      EXPECT_NEAR(data->velocity[i][1], -2.F, 1e-4F);
      ++hit;
    }
  }
  EXPECT_GT(hit, 1000);
}

TEST(Data, GrainsCarryTheirBodyAndVelocity) {
  MeshScene heap = testing::heap(5000, {GrainShape::straw, Vec3(1, 1, 5)}, "straw");
  Channel velocity{"velocity", ChannelOn::particle, 3, ChannelStorage::float32, {}};
  for (int i = 0; i < 5000; ++i)
    velocity.values.insert(velocity.values.end(), {0.0, -1.5, 0.0});
  heap.frame.bodies[0].channels.push_back(velocity);
  RenderPlan plan = testing::small_plan(heap);
  plan.data = DataWanted::yes;
  Result<Renderer> renderer = Renderer::create(plan, heap.scene);
  ASSERT_TRUE(renderer.ok());
  const Result<DataLayers> data = renderer->draw_data(heap.frame, {});
  ASSERT_TRUE(data.ok()) << data.error().message;
  int hit = 0;
  for (std::size_t i = 0; i < data->body.size(); ++i) {
    if (data->body[i] == 0)
      continue;
    EXPECT_EQ(data->body[i], 1U);
    EXPECT_NEAR(data->velocity[i][1], -1.5F, 1e-4F);
    ++hit;
  }
  EXPECT_GT(hit, 1000);
}

TEST(Background, CatchesShadowsInAlphaAloneAndIsClearElsewhere) {
  const MeshScene ball = make_mesh_scene(testing::sphere(Vec3(0, 1, 0), 1, 48, 96), "ball", "clay");
  RenderPlan plan = testing::small_plan(ball);
  plan.ground.kind = Ground::Kind::catch_shadow;
  plan.background = Background::clear;
  plan.camera.margin = 0.5;
  Result<Renderer> renderer = Renderer::create(plan, ball.scene);
  ASSERT_TRUE(renderer.ok()) << renderer.error().message;
  const Result<LinearImage> image = renderer->draw_linear(ball.frame, {});
  ASSERT_TRUE(image.ok());
  EXPECT_LT(image->at(2, 2)[3], 0.01F);
  double darkest = 0.0;
  for (int y = 0; y < image->height; ++y) {
    for (int x = 0; x < image->width; ++x) {
      const float* pixel = image->at(x, y);
      EXPECT_GE(pixel[3], 0.F);
      EXPECT_LE(pixel[3], 1.001F);
      if (pixel[0] == 0.F)
        darkest = std::max(darkest, static_cast<double>(pixel[3]));
    }
  }
  EXPECT_GT(darkest, 0.4);
}

TEST(Environment, WhiteBallVanishesInAWhitePictureOfTheSurroundings) {
  const MeshScene ball = make_mesh_scene(testing::sphere(Vec3(0, 0, 0), 1, 64, 128), "ball", "");
  RenderPlan plan = testing::small_plan(ball);
  plan.samples = 1;
  plan.ground.kind = Ground::Kind::none;
  plan.default_look.base_colour = Eigen::Vector3f::Ones();
  LinearImage white{64, 32, std::vector<float>(64 * 32 * 4, 1.f)};
  const Result<Rig> rig = image_rig(white);
  ASSERT_TRUE(rig.ok());
  plan.rig = *rig;
  plan.rig.occlusion = Rig::Occlusion::none;
  plan.rig.backdrop = Rig::Backdrop::surroundings;
  Result<Renderer> renderer = Renderer::create(plan, ball.scene);
  ASSERT_TRUE(renderer.ok()) << renderer.error().message;
  const Result<LinearImage> image = renderer->draw_linear(ball.frame, {});
  ASSERT_TRUE(image.ok());
  double worst = 0.0;
  for (std::size_t i = 0; i < image->pixels.size(); i += 4)
    worst = std::max(worst, std::abs(1.0 - static_cast<double>(image->pixels[i])));
  EXPECT_LT(worst, 0.015);
}

TEST(Glass, LetsWhatIsBehindThroughAndMirrorsAtItsRim) {
  MeshScene scene = make_mesh_scene(testing::sphere(Vec3(0, 1, 0), 1, 48, 96), "glass", "glass");
  const MeshScene behind = make_mesh_scene(testing::box(Vec3(-.3, .7, -3), Vec3(.3, 1.3, -2.5)), "behind", "red");
  scene.scene.bodies.push_back(behind.scene.bodies[0]);
  scene.frame.bodies.push_back(behind.frame.bodies[0]);
  scene.bounds.include(behind.bounds);
  RenderPlan plan = testing::small_plan(scene);
  plan.looks["red"].base_colour = {.6f, .02f, .02f};
  plan.camera.placed = PlacedCamera{Vec3(0, 1, 6), Vec3(0, 1, 0), {}};
  Result<Renderer> renderer = Renderer::create(plan, scene.scene);
  ASSERT_TRUE(renderer.ok()) << renderer.error().message;
  const Result<LinearImage> image = renderer->draw_linear(scene.frame, {});
  ASSERT_TRUE(image.ok()) << image.error().message;
  const float* middle = image->at(96, 54);
  EXPECT_GT(middle[0], 3.F * middle[2]); // the red box, seen through both walls
}

/// A ball looks the same from all around, so whatever changes while it turns is flicker.
TEST(Flicker, OfAStillTurntableStaysBelowOneGreyLevel) {
  constexpr int SEGMENTS = 96;
  const MeshScene ball = make_mesh_scene(testing::sphere(Vec3(0, .5, 0), .5, 48, SEGMENTS), "ball", "skin");
  RenderPlan plan = testing::small_plan(ball);
  plan.framing = Framing::orbit;
  Result<Renderer> renderer = Renderer::create(plan, ball.scene);
  ASSERT_TRUE(renderer.ok());
  std::vector<double> sum(static_cast<std::size_t>(plan.size.width * plan.size.height), 0.0);
  std::vector<double> square = sum;
  constexpr int STEPS = 6;
  for (int i = 0; i < STEPS; ++i) {
    Picture picture;
    picture.orbit_turns = static_cast<double>(i) / SEGMENTS;
    const Result<Image> image = renderer->draw(ball.frame, picture);
    ASSERT_TRUE(image.ok());
    for (std::size_t p = 0; p < sum.size(); ++p) {
      const double value = image->pixels[4 * p + 1];
      sum[p] += value / STEPS;
      square[p] += value * value / STEPS;
    }
  }
  double variance = 0.0;
  double worst = 0.0;
  for (std::size_t p = 0; p < sum.size(); ++p) {
    const double own = std::max(0.0, square[p] - sum[p] * sum[p]);
    variance += own / static_cast<double>(sum.size());
    worst = std::max(worst, std::sqrt(own));
  }
  EXPECT_LT(std::sqrt(variance), 0.35);
  EXPECT_LT(worst, 12.0);
}

} // namespace
} // namespace wry::render
