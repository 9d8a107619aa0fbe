#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/render/pictures_support.h"
#include "tests/render/shapes_support.h"

namespace wry::render {
namespace {

using ::testing::HasSubstr;

Result<Image> drawn(const RenderPlan& plan, const MeshScene& scene, const std::string& view = "beauty") {
  Result<Renderer> renderer = Renderer::create(plan, scene.scene);
  if (!renderer.ok())
    return renderer.error();
  Picture picture;
  picture.view = view;
  return renderer->draw(scene.frame, picture);
}

TEST(Grains, EveryShapeIsDrawnAndCoversTheSameHeap) {
  for (const GrainShape shape : {GrainShape::sphere, GrainShape::rod, GrainShape::straw, GrainShape::card,
                                 GrainShape::coin, GrainShape::brick}) {
    const MeshScene scene = testing::heap(3000, {shape, Vec3(1, 1, 1)}, "straw");
    Result<Renderer> renderer = Renderer::create(testing::small_plan(scene), scene.scene);
    ASSERT_TRUE(renderer.ok()) << renderer.error().message;
    const Result<LinearImage> image = renderer->draw_linear(scene.frame, {});
    ASSERT_TRUE(image.ok()) << image.error().message;
    double covered = 0.0;
    for (std::size_t i = 3; i < image->pixels.size(); i += 4)
      covered += static_cast<double>(image->pixels[i]);
    covered /= static_cast<double>(image->width * image->height);
    EXPECT_GT(covered, 0.08) << static_cast<int>(shape);
    EXPECT_LT(covered, 0.45) << static_cast<int>(shape);
  }
}

/// The share of each pixel that something covers.
std::vector<float> coverage(const RenderPlan& plan, const MeshScene& scene) {
  std::vector<float> alpha;
  Result<Renderer> renderer = Renderer::create(plan, scene.scene);
  if (!renderer.ok())
    return alpha;
  const Result<LinearImage> image = renderer->draw_linear(scene.frame, {});
  for (std::size_t i = 3; image.ok() && i < image->pixels.size(); i += 4)
    alpha.push_back(static_cast<float>(image->pixels[i]));
  return alpha;
}

/// Shadows of bricks are simpler than those of meshes: what can be alike is what they cover.
TEST(Grains, OfAnArtistMeshThatIsABoxCoverWhatBricksCover) {
  MeshScene scene = testing::heap(1500, {GrainShape::brick, Vec3(1, 2, 4)}, "straw");
  const RenderPlan plan = testing::small_plan(scene);
  const std::vector<float> bricks = coverage(plan, scene);
  const geometry::SurfaceMesh box = testing::box(Vec3::Constant(-0.5), Vec3::Constant(0.5));
  SceneBody& body = scene.scene.bodies[0];
  body.grain.shape = GrainShape::mesh;
  body.rest_positions = box.vertices;
  body.triangles = box.triangles;
  const std::vector<float> meshes = coverage(plan, scene);
  ASSERT_FALSE(bricks.empty());
  ASSERT_EQ(bricks.size(), meshes.size());
  std::size_t covered = 0, apart = 0;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    covered += bricks[i] > 0.5F ? 1 : 0;
    apart += std::abs(bricks[i] - meshes[i]) > 0.1F ? 1 : 0;
  }
  EXPECT_GT(covered, bricks.size() / 20);
  EXPECT_LE(apart, bricks.size() / 2000);
}

TEST(Grains, ThoseHiddenBehindOthersAreNotMissed) {
  const MeshScene scene = testing::heap(60'000, {GrainShape::rod, Vec3(1, 1, 10)}, "straw");
  RenderPlan plan = testing::small_plan(scene);
  plan.samples = 4;
  const Result<Image> some = drawn(plan, scene);
  ASSERT_TRUE(some.ok()) << some.error().message;
  plan.hidden_grains = RenderPlan::HiddenGrains::drawn;
  const Result<Image> all = drawn(plan, scene);
  ASSERT_TRUE(all.ok()) << all.error().message;
  ASSERT_EQ(some->pixels.size(), all->pixels.size());
  // A grain may look through a gap that is too narrow for the first sub-frame to see.
  std::size_t differ = 0;
  int most = 0;
  for (std::size_t i = 0; i < all->pixels.size(); ++i) {
    differ += some->pixels[i] != all->pixels[i] ? 1 : 0;
    most = std::max(most, std::abs(some->pixels[i] - all->pixels[i]));
  }
  EXPECT_LT(differ, all->pixels.size() / 2000);
  EXPECT_LT(most, 32) << differ;
}

/// The same heap with a grain too few for burial to look at it, and whole.
TEST(Grains, BuriedOnesAreNotMissed) {
  MeshScene scene = testing::heap(40'000, {GrainShape::brick, Vec3(1, 1, 3)}, "straw");
  RenderPlan plan = testing::small_plan(scene);
  plan.samples = 4;
  const Result<Image> culled = drawn(plan, scene);
  ASSERT_TRUE(culled.ok()) << culled.error().message;
  // Split in clouds too small to be culled.
  MeshScene whole = scene;
  whole.scene.bodies.clear();
  whole.frame.bodies.clear();
  constexpr std::size_t PART = 1999;
  const std::vector<Channel>& channels = scene.frame.bodies[0].channels;
  for (std::size_t first = 0; first < 40'000; first += PART) {
    const std::size_t count = std::min(PART, 40'000 - first);
    FrameBody part;
    part.name = "heap";
    for (const Channel& channel : channels) {
      const auto width = static_cast<std::size_t>(channel.components);
      Channel cut{channel.name, channel.on, channel.components, channel.storage, {}};
      const auto begin = channel.values.begin() + static_cast<std::ptrdiff_t>(first * width);
      cut.values.assign(begin, begin + static_cast<std::ptrdiff_t>(count * width));
      part.channels.push_back(std::move(cut));
    }
    whole.scene.bodies.push_back(scene.scene.bodies[0]);
    whole.frame.bodies.push_back(std::move(part));
  }
  RenderPlan plain = plan;
  plain.looks["straw"].colour_variation = 0.f; // both count the grains of a body
  plain.looks["straw"].size_variation = 0.f;
  RenderPlan plain_culled = plain;
  const Result<Image> all = drawn(plain, whole);
  const Result<Image> some = drawn(plain_culled, scene);
  ASSERT_TRUE(all.ok()) << all.error().message;
  ASSERT_TRUE(some.ok());
  int apart = 0;
  for (std::size_t i = 0; i < all->pixels.size(); ++i)
    apart += std::abs(static_cast<int>(all->pixels[i]) - static_cast<int>(some->pixels[i])) > 3 ? 1 : 0;
  EXPECT_LT(apart, static_cast<int>(all->pixels.size()) / 1000);
}

TEST(Grains, OrientationThatIsNotFiniteIsRefusedByName) {
  MeshScene scene = testing::heap(10, {GrainShape::rod, Vec3(1, 1, 4)}, "straw");
  scene.frame.bodies[0].channels[1].values[4 * 7] = std::numeric_limits<double>::quiet_NaN();
  const Result<Image> image = drawn(testing::small_plan(scene), scene);
  ASSERT_FALSE(image.ok());
  EXPECT_EQ(image.error().code, ErrorCode::bad_input);
  EXPECT_THAT(image.error().message, HasSubstr("orientation of particle 7"));
}

TEST(Grains, ShowHeatOfAParticleChannel) {
  MeshScene scene = testing::heap(2000, {GrainShape::sphere, Vec3(1, 1, 1)}, "straw");
  Channel heat{"speed", ChannelOn::particle, 1, ChannelStorage::float32, std::vector<double>(2000, 1.0)};
  scene.frame.bodies[0].channels.push_back(heat);
  RenderPlan plan = testing::small_plan(scene);
  plan.views.push_back(heat_view({.channel = "speed", .low = 0, .high = 1, .title = "", .unit = "m/s"}));
  const Result<Image> image = drawn(plan, scene, "heat-speed");
  ASSERT_TRUE(image.ok()) << image.error().message;
  // All grains have the topmost colour, yellow: green well above blue in the middle of the heap.
  const std::uint8_t* pixel = image->at(96, 62);
  EXPECT_GT(static_cast<int>(pixel[1]), static_cast<int>(pixel[2]) + 60);
}

} // namespace
} // namespace wry::render
