#include "render/renderer.h"

#include <limits>

#include <gmock/gmock.h>

#include "tests/render/pictures_support.h"
#include "tests/render/shapes_support.h"

namespace wry::render {
namespace {

using ::testing::HasSubstr;

TEST(Renderer, DrawsTheSubjectWithAShadowOnTheGround) {
  const MeshScene ball = make_mesh_scene(testing::sphere(Vec3(0, 1, 0), 1, 48, 96), "ball", "clay");
  Result<Renderer> renderer = Renderer::create(testing::small_plan(ball), ball.scene);
  ASSERT_TRUE(renderer.ok()) << renderer.error().message;
  const Result<LinearImage> image = renderer->draw_linear(ball.frame, {});
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_GT(image->at(96, 54)[3], 0.99F);
  EXPECT_EQ(image->at(2, 2)[3], 0.0F);
  // The key comes from the left, so the floor is darker right of the ball than left of it.
  EXPECT_LT(image->at(140, 98)[0], 0.7F * image->at(40, 98)[0]);
}

TEST(Renderer, RefusesPositionsThatAreNotFinite) {
  MeshScene ball = make_mesh_scene(testing::sphere(Vec3(0, 1, 0), 1, 8, 8), "ball", "clay");
  std::vector<double> positions(static_cast<std::size_t>(ball.scene.bodies[0].rest_positions.size()), 0.0);
  positions[40] = std::numeric_limits<double>::quiet_NaN();
  ball.frame.bodies[0].channels.push_back({"position", ChannelOn::vertex, 3, ChannelStorage::float64, positions});
  Result<Renderer> renderer = Renderer::create(testing::small_plan(ball), ball.scene);
  ASSERT_TRUE(renderer.ok());
  const Result<Image> image = renderer->draw(ball.frame, {});
  ASSERT_FALSE(image.ok());
  EXPECT_EQ(image.error().code, ErrorCode::bad_input);
  EXPECT_THAT(image.error().message, HasSubstr("vertex 13"));
}

TEST(Renderer, RefusesASceneWithoutTriangles) {
  const MeshScene ball = make_mesh_scene(testing::sphere(Vec3(0, 1, 0), 1, 8, 8), "ball", "clay");
  SceneStatic empty = ball.scene;
  empty.bodies[0].triangles.resize(0, 3);
  const Result<Renderer> renderer = Renderer::create(testing::small_plan(ball), empty);
  ASSERT_FALSE(renderer.ok());
  EXPECT_EQ(renderer.error().code, ErrorCode::bad_input);
  EXPECT_THAT(renderer.error().message, HasSubstr("nothing to draw"));
}

TEST(Renderer, RefusesACameraInsideTheSubject) {
  const MeshScene ball = make_mesh_scene(testing::sphere(Vec3(0, 1, 0), 1, 24, 24), "ball", "clay");
  RenderPlan plan = testing::small_plan(ball);
  plan.camera.placed = PlacedCamera{Vec3(0.1, 1.2, 0.3), Vec3(0, 1, 0), {}};
  Result<Renderer> renderer = Renderer::create(plan, ball.scene);
  ASSERT_TRUE(renderer.ok());
  const Result<Image> image = renderer->draw(ball.frame, {});
  ASSERT_FALSE(image.ok());
  EXPECT_THAT(image.error().message, HasSubstr("inside body ball"));
}

TEST(Renderer, NamesTheViewsThereAre) {
  const MeshScene ball = make_mesh_scene(testing::sphere(Vec3(0, 1, 0), 1, 8, 8), "ball", "clay");
  Result<Renderer> renderer = Renderer::create(testing::small_plan(ball), ball.scene);
  ASSERT_TRUE(renderer.ok());
  Picture picture;
  picture.view = "beuty";
  const Result<Image> image = renderer->draw(ball.frame, picture);
  ASSERT_FALSE(image.ok());
  EXPECT_THAT(image.error().message, HasSubstr("beauty, clay, wire"));
}

TEST(Renderer, RefusesAFrameOfAnotherScene) {
  const MeshScene ball = make_mesh_scene(testing::sphere(Vec3(0, 1, 0), 1, 8, 8), "ball", "clay");
  Result<Renderer> renderer = Renderer::create(testing::small_plan(ball), ball.scene);
  ASSERT_TRUE(renderer.ok());
  EXPECT_FALSE(renderer->draw(Frame(), {}).ok());
}

} // namespace
} // namespace wry::render
