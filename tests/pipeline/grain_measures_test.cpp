#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/measure/grain_measures.h"

namespace wry::pipeline {
namespace {

/// A cube of 1 m as a closed mesh, its low corner at the origin, that rises by 1 m in 1 s.
std::shared_ptr<const scene::Collider> rising_cube() {
  scene::BoxObstacle box;
  box.centre = Vec3::Constant(0.5);
  const Result<geometry::SurfaceMesh> surface = scene::obstacle_surface(box, 1.0);
  EXPECT_TRUE(surface) << surface.error().message;
  auto collider = std::make_shared<scene::Collider>();
  collider->shape = scene::MeshObstacle{std::make_shared<const geometry::SurfaceMesh>(*surface), true, 0.0};
  scene::MotionKeys keys;
  keys.keys = {{0.0, Vec3::Zero(), Vec3::UnitZ(), 0.0}, {1.0, Vec3::UnitZ(), Vec3::UnitZ(), 0.0}};
  collider->motion = *scene::Motion::along_keys(keys);
  return collider;
}

std::shared_ptr<const scene::Collider> floor_at(double height) {
  auto collider = std::make_shared<scene::Collider>();
  collider->shape = scene::PlaneObstacle{Vec3(0, 0, height), Vec3::UnitZ()};
  return collider;
}

struct Grain {
  Vec3 position;
  double speed = 0.0;
};

/// Rods of 2 x 2 x 10 cm.
struct Heap {
  MeasurePlan plan;
  SceneStatic scene;
  Frame frame;

  Heap(const std::vector<Grain>& grains, std::vector<std::shared_ptr<const scene::Collider>> colliders, double time) {
    plan.up = Vec3::UnitZ();
    plan.drawn_colliders = std::make_shared<const DrawnColliders>(std::move(colliders));
    scene.bodies.resize(2);
    scene.bodies[0].name = "load";
    scene.bodies[1].name = "load.grains";
    frame.time = time;
    frame.bodies.resize(2);
    frame.bodies[1].name = "load.grains";
    Channel position{"position", ChannelOn::particle, 3, ChannelStorage::float64, {}};
    Channel velocity{"velocity", ChannelOn::particle, 3, ChannelStorage::float32, {}};
    Channel size{"size", ChannelOn::particle, 3, ChannelStorage::float32, {}};
    for (const Grain& grain : grains) {
      for (int k = 0; k < 3; ++k)
        position.values.push_back(grain.position[k]);
      velocity.values.insert(velocity.values.end(), {grain.speed, 0.0, 0.0});
      size.values.insert(size.values.end(), {0.02, 0.02, 0.1});
    }
    frame.bodies[1].channels = {position, velocity, size};
  }
  double inside() const { return grains_inside(plan, scene, frame); }
  double hover() const { return grain_hover(plan, scene, frame); }
};

TEST(GrainMeasures, CountsCentresInsideWhereTheColliderIsNow) {
  const std::vector<Grain> grains = {{{0.5, 0.5, 0.5}}, {{0.5, 0.5, 1.2}}, {{1.01, 0.5, 0.9}}};
  EXPECT_EQ(Heap(grains, {rising_cube()}, 0.0).inside(), 1.0);
  EXPECT_EQ(Heap(grains, {rising_cube()}, 0.4).inside(), 2.0);
  EXPECT_EQ(Heap(grains, {rising_cube()}, 1.0).inside(), 1.0);
  EXPECT_EQ(Heap(grains, {rising_cube(), floor_at(0.6)}, 0.0).inside(), 1.0);
}

TEST(GrainMeasures, HoverIsTheGapBelowWhatRestsOnNothingElse) {
  const auto lone = [](double height) { return Grain{{1, 0, height}}; };
  // On the floor; 5 cm above it; the same, but with a grain beneath; as high, but moving.
  EXPECT_NEAR(Heap({{{0, 0, 0.01}}}, {floor_at(0)}, 0.0).hover(), 0.0, 1e-12);
  EXPECT_NEAR(Heap({lone(0.06)}, {floor_at(0)}, 0.0).hover(), 0.05, 1e-12);
  EXPECT_NEAR(Heap({{{0, 0, 0.01}}, {{0.03, 0, 0.06}}}, {floor_at(0)}, 0.0).hover(), 0.0, 1e-12);
  EXPECT_NEAR(Heap({{{0, 0, 0.01}}, {{1, 0, 0.06}, 0.5}}, {floor_at(0)}, 0.0).hover(), 0.0, 1e-12);
  EXPECT_NEAR(Heap({{{0.5, 0.5, 1.04}}}, {rising_cube(), floor_at(0)}, 0.0).hover(), 0.03, 1e-6);
}

TEST(GrainMeasures, ABodyWithoutGrainsHasNone) {
  Heap heap({}, {floor_at(0)}, 0.0);
  heap.frame.bodies.pop_back();
  EXPECT_TRUE(std::isnan(heap.inside()));
  EXPECT_TRUE(std::isnan(heap.hover()));
}

} // namespace
} // namespace wry::pipeline
