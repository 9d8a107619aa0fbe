#include <cmath>

#include <gtest/gtest.h>

#include "tests/render/pictures_support.h"
#include "tests/render/shapes_support.h"

namespace wry::render {
namespace {

double rmse(const LinearImage& a, const LinearImage& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    if (i % 4 != 3)
      sum += std::pow(static_cast<double>(a.pixels[i]) - static_cast<double>(b.pixels[i]), 2);
  }
  return std::sqrt(sum / (0.75 * static_cast<double>(a.pixels.size())));
}

/// Edges, penumbra, lens and motion at once: the error against 256 sub-frames falls as sub-frames grow, at least as
/// fast as that of random samples would.
TEST(Convergence, ErrorFallsAsSubFramesGrow) {
  MeshScene scene = make_mesh_scene(testing::pebble(60, 100), "pebble", "skin");
  const auto rows = static_cast<std::size_t>(scene.scene.bodies[0].rest_positions.rows());
  Channel velocity{"velocity", ChannelOn::vertex, 3, ChannelStorage::float32, std::vector<double>(3 * rows, 1.0)};
  scene.frame.bodies[0].channels.push_back(velocity);
  RenderPlan plan = testing::small_plan(scene);
  plan.shutter = 0.5;
  plan.camera.f_stop = 0.4;
  const auto drawn = [&](int samples) {
    plan.samples = samples;
    Result<Renderer> renderer = Renderer::create(plan, scene.scene);
    EXPECT_TRUE(renderer.ok());
    return *renderer->draw_linear(scene.frame, {});
  };
  const LinearImage truth = drawn(256);
  const double four = rmse(drawn(4), truth);
  const double sixteen = rmse(drawn(16), truth);
  const double sixty_four = rmse(drawn(64), truth);
  EXPECT_LT(sixteen, 0.6 * four);
  EXPECT_LT(sixty_four, 0.6 * sixteen);
}

} // namespace
} // namespace wry::render
