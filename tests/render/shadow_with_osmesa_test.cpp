#include <cmath>

#include <gtest/gtest.h>

#include "render/passes/light_state.h"
#include "tests/render/pictures_support.h"
#include "tests/render/shapes_support.h"

namespace wry::render {
namespace {

/// One hard light over a ball on the floor, and nothing else: what a ray finds is what must be drawn.
struct HardLitBall {
  Vec3 centre = Vec3(0.2, 1.5, 0.1);
  double radius = 1.0;
  MeshScene scene = make_mesh_scene(testing::sphere(centre, radius, 128, 256), "ball", "clay");
  RenderPlan plan = make_plan();

  RenderPlan make_plan() const {
    RenderPlan made = testing::small_plan(scene);
    made.size = {320, 240};
    made.samples = 1;
    made.camera.elevation_degrees = 30;
    made.camera.margin = 0.5;
    made.ground.height = 0.0;
    Light light;
    light.azimuth_degrees = -50;
    light.elevation_degrees = 50;
    light.angular_radius_degrees = 0.01;
    light.shadow = Light::Shadow::mapped;
    made.rig = Rig();
    made.rig.lights = {light};
    made.rig.sky.setZero();
    return made;
  }

  bool hits(const Vec3& from, const Vec3& direction, double widened) const {
    const Vec3 to = centre - from;
    const double along = to.dot(direction.normalized());
    return along > 0.0 && to.squaredNorm() - along * along < std::pow(radius + widened, 2);
  }
};

TEST(Shadow, AgreesWithRaysOnTheFloorAndOnTheSilhouette) {
  HardLitBall truth;
  Result<Renderer> renderer = Renderer::create(truth.plan, truth.scene.scene);
  ASSERT_TRUE(renderer.ok());
  const Result<LinearImage> image = renderer->draw_linear(truth.scene.frame, {});
  ASSERT_TRUE(image.ok());
  const Camera camera =
      *frame_camera(truth.plan.camera, truth.plan.up, truth.plan.bounds, truth.plan.size, Framing::still, 0.0);
  const Vec3 to_light =
      direction_to_light(truth.plan.rig.lights[0], truth.plan.rig, truth.plan.up, truth.plan.camera.azimuth_degrees);
  constexpr double EDGE = 0.02; // [m] about two texels of the map, or a pixel: no opinion there
  int lit = 0;
  int dark = 0;
  for (int y = 0; y < image->height; ++y) {
    for (int x = 0; x < image->width; ++x) {
      const Vec3 ray = camera.axes * Vec3((2.0 * (x + 0.5) / image->width - 1.0) * camera.tan_half_width,
                                          (1.0 - 2.0 * (y + 0.5) / image->height) * camera.tan_half_height, -1.0);
      const float* pixel = image->at(x, y);
      if (truth.hits(camera.eye, ray, -EDGE)) {
        EXPECT_EQ(pixel[3], 1.F) << x << " " << y;
        continue;
      }
      if (truth.hits(camera.eye, ray, EDGE) || ray.y() >= -0.05)
        continue;
      EXPECT_EQ(pixel[3], 0.F) << x << " " << y;
      const Vec3 floor = camera.eye - ray * (camera.eye.y() / ray.y());
      if (truth.hits(floor, to_light, -EDGE)) {
        EXPECT_LT(pixel[0], 1e-4F) << x << " " << y;
        ++dark;
      } else if (!truth.hits(floor, to_light, EDGE)) {
        EXPECT_GT(pixel[0], 0.02F) << x << " " << y;
        ++lit;
      }
    }
  }
  EXPECT_GT(dark, 500);
  EXPECT_GT(lit, 20000);
}

TEST(Shadow, LitSideOfASmoothBallHasNoAcne) {
  HardLitBall truth;
  Result<Renderer> renderer = Renderer::create(truth.plan, truth.scene.scene);
  ASSERT_TRUE(renderer.ok());
  const Result<LinearImage> shadowed = renderer->draw_linear(truth.scene.frame, {});
  RenderPlan open = truth.plan;
  open.rig.lights[0].shadow = Light::Shadow::none;
  Result<Renderer> without = Renderer::create(open, truth.scene.scene);
  ASSERT_TRUE(without.ok());
  const Result<LinearImage> unshadowed = without->draw_linear(truth.scene.frame, {});
  ASSERT_TRUE(shadowed.ok() && unshadowed.ok());
  // The half-lit rim of the terminator may differ; where the light falls at less than 75 degrees nothing may.
  float brightest = 0.F;
  for (std::size_t i = 0; i < unshadowed->pixels.size(); i += 4) {
    if (unshadowed->pixels[i + 3] == 1.F)
      brightest = std::max(brightest, unshadowed->pixels[i]);
  }
  int compared = 0;
  for (std::size_t i = 0; i < unshadowed->pixels.size(); i += 4) {
    if (unshadowed->pixels[i + 3] != 1.F || unshadowed->pixels[i] < 0.26F * brightest)
      continue;
    EXPECT_GT(shadowed->pixels[i], 0.99F * unshadowed->pixels[i]) << i / 4;
    ++compared;
  }
  EXPECT_GT(compared, 1000);
}

/// What is beyond the map's depth counts as near its end, and gets the narrow penumbra of something near.
TEST(Shadow, MapReachesTheFloorHoweverDeepItLies) {
  const MeshScene scene = make_mesh_scene(testing::box(Vec3(-1, 1.5, -1), Vec3(1, 1.52, 1)), "plate", "clay");
  RenderPlan plan = testing::small_plan(scene);
  for (const double floor : {1.5, 1.0, 0.0, -3.0}) {
    plan.ground.height = floor;
    const LightState lights = light_state(plan, 0.0, 0, 8);
    ASSERT_GE(lights.shadowed, 0);
    const Eigen::Vector3f to_light = lights.directions.col(lights.shadowed).head<3>();
    for (const Vec3& corner : {Vec3(-1, 1.5, -1), Vec3(1, 1.52, 1), Vec3(1, 1.52, -1), Vec3(-1, 1.5, 1)}) {
      const Eigen::Vector3f from = (corner - plan.bounds.centre()).cast<float>();
      const float way = static_cast<float>(1.5 - floor) / to_light.y();
      const float caster = (lights.clip_from_world_shadow * from.homogeneous()).z();
      const float receiver = (lights.clip_from_world_shadow * (from - way * to_light).homogeneous()).z();
      EXPECT_GT(caster, 0.F);
      EXPECT_LT(receiver, 1.F) << floor;
      EXPECT_NEAR((receiver - caster) * lights.shadow_depth, way, 1e-4F);
    }
  }
}

} // namespace
} // namespace wry::render
