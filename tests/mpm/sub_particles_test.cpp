#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "sim/mpm/grains/blue_noise.h"
#include "sim/mpm/mpm_simulation.h"
#include "sim/mpm/seeding.h"

namespace wry::mpm {
namespace {

constexpr double CELL = 0.02;

SeedSettings cells_of(double cell) {
  SeedSettings settings;
  settings.cell = cell;
  return settings;
}

/// A cube of .2 m on a lattice of two particles per cell edge, its low corner at `low`.
MpmPlan cube(const Vec3& low) {
  MpmPlan plan;
  MpmBody body;
  body.name = "cube";
  const auto seeds = fill(
      low, low + Vec3::Constant(0.2), [](const Vec3&) { return true; }, cells_of(CELL));
  body.positions = std::make_shared<const Points>(seeds->positions);
  body.particle_volume = seeds->volume;
  body.sub_particles.emplace();
  body.sub_particles->name = "grains";
  body.sub_particles->per_particle = 2;
  plan.bodies.push_back(body);
  plan.settings.cell = CELL;
  return plan;
}

std::unique_ptr<MpmSimulation> run(const MpmPlan& plan, double end, double fps = 24.0, int threads = 1) {
  auto simulation = MpmSimulation::create(plan, threads, Isa::sse4);
  EXPECT_TRUE(simulation) << simulation.error().message;
  for (int frame = 1; frame <= std::lround(end * fps); ++frame) {
    while ((*simulation)->time() < frame / fps * (1.0 - 1e-12)) {
      const auto step = (*simulation)->step(frame / fps);
      EXPECT_TRUE(step) << step.error().message;
      if (!step)
        return std::move(*simulation);
    }
  }
  return std::move(*simulation);
}

Vec3 row3(const wry::Channel& channel, std::size_t i) {
  return {channel.values[3 * i], channel.values[3 * i + 1], channel.values[3 * i + 2]};
}
Vec4 row4(const wry::Channel& channel, std::size_t i) {
  return {channel.values[4 * i], channel.values[4 * i + 1], channel.values[4 * i + 2], channel.values[4 * i + 3]};
}
const wry::Channel& grains_channel(const Frame& frame, const char* name) {
  return *find_channel(frame.bodies.back(), name);
}

TEST(SubParticles, AreSpreadWithoutClumps) {
  const auto seeds = fill(
      Vec3::Zero(), Vec3::Constant(0.1), [](const Vec3&) { return true; }, cells_of(0.02));
  const Points points = spread_in_particles(seeds->positions, seeds->volume, 4, 9);
  ASSERT_EQ(points.rows(), 4 * seeds->positions.rows());
  const double spacing = std::cbrt(seeds->volume / 4);
  double least = 1.0, mean = 0.0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    double nearest = 1.0;
    for (Eigen::Index j = 0; j < points.rows(); ++j) {
      if (i != j)
        nearest = std::min(nearest, (points.row(i) - points.row(j)).norm());
    }
    least = std::min(least, nearest);
    mean += nearest / static_cast<double>(points.rows());
    EXPECT_GE(points.row(i).minCoeff(), -1e-12);
    EXPECT_LE(points.row(i).maxCoeff(), 0.1 + 1e-12);
  }
  EXPECT_GT(mean, 0.68 * spacing); // random points: .554 of the spacing
  EXPECT_GT(least, 0.15 * spacing);
}

TEST(SubParticles, TurnAndTravelWithMatterThatSpins) {
  MpmPlan plan = cube(Vec3::Constant(0.1));
  plan.gravity.setZero();
  const Vec3 middle = Vec3::Constant(0.2), spin(0.0, 0.0, 3.0), drift(0.2, 0.0, 0.1);
  plan.bodies[0].velocity_field = [=](const Vec3& x) { return Vec3(drift + spin.cross(x - middle)); };
  plan.bodies[0].sub_particles->tilt_degrees = 0.0;
  const Frame before = run(plan, 0.0)->snapshot(1);
  const double end = 0.25;
  const Frame after = run(plan, end)->snapshot(2);
  const Mat3 R = rodrigues(end * spin);
  const auto &x0 = grains_channel(before, "position"), &x1 = grains_channel(after, "position");
  const auto &q0 = grains_channel(before, "orientation"), &q1 = grains_channel(after, "orientation");
  double place = 0.0, angle = 0.0;
  const std::size_t count = x0.values.size() / 3;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 expected = middle + end * drift + R * (row3(x0, i) - middle);
    place = std::max(place, (row3(x1, i) - expected).norm());
    angle += rotation_distance(row4(q1, i), quaternion_product(quaternion_exponential(end * spin), row4(q0, i))) /
             static_cast<double>(count);
  }
  EXPECT_LT(place, 0.35 * CELL);
  EXPECT_LT(angle, 0.03);
}

TEST(SubParticles, FlyFreelyWhereThereIsNoMatter) {
  MpmPlan plan = cube(Vec3::Constant(0.1));
  plan.bodies[0].sub_particles->escape_density = 10.0; // nothing is dense enough to carry them
  plan.bodies[0].initial_velocity = Vec3(0.3, 0.0, 0.0);
  const Frame before = run(plan, 0.0)->snapshot(1);
  const double end = 0.25;
  const Frame after = run(plan, end)->snapshot(2);
  const Vec3 fall = end * Vec3(0.3, 0, 0) + 0.5 * end * end * plan.gravity;
  const auto &x0 = grains_channel(before, "position"), &x1 = grains_channel(after, "position");
  double worst = 0.0;
  for (std::size_t i = 0; i < x0.values.size() / 3; ++i)
    worst = std::max(worst, (row3(x1, i) - row3(x0, i) - fall).norm());
  EXPECT_LT(worst, 0.03 * fall.norm()); // symplectic Euler, a step an update
}

MpmPlan falling_sand() {
  MpmPlan plan = cube(Vec3(0.1, 0.03, 0.1));
  plan.bodies[0].material.plasticity = Plasticity::drucker_prager;
  auto floor = std::make_shared<scene::Collider>();
  floor->name = "floor";
  floor->shape = scene::PlaneObstacle{};
  plan.colliders.push_back(floor);
  return plan;
}

TEST(SubParticles, NeverEnterTheFloorAndComeToRestOnIt) {
  const MpmPlan plan = falling_sand();
  const auto simulation = run(plan, 0.5);
  const Frame frame = simulation->snapshot(1);
  const auto &x = grains_channel(frame, "position"), &v = grains_channel(frame, "velocity"),
             &phase = grains_channel(frame, "phase");
  double lowest = 1.0;
  std::size_t flying = 0;
  for (std::size_t i = 0; i < x.values.size() / 3; ++i) {
    lowest = std::min(lowest, x.values[3 * i + 1]);
    flying += phase.values[i] == 1.0 && row3(v, i).norm() > 0.2 ? 1 : 0;
  }
  EXPECT_GE(lowest, 0.0);
  EXPECT_LT(lowest, plan.bodies[0].sub_particles->size.z());
  EXPECT_LT(flying, x.values.size() / 3 / 100);
}

TEST(SubParticles, AreTheSameOnAnyNumberOfThreadsAndAfterARestart) {
  const MpmPlan plan = falling_sand();
  const auto one = run(plan, 0.125), two = run(plan, 0.125, 24.0, 2);
  const std::vector<wry::Channel> a = one->snapshot(1).bodies.back().channels,
                                  b = two->snapshot(1).bodies.back().channels;
  for (std::size_t c = 0; c < a.size(); ++c)
    EXPECT_EQ(a[c].values, b[c].values) << a[c].name;
  auto again = MpmSimulation::create(plan, 1, Isa::sse4);
  ASSERT_TRUE((*again)->restore(one->archive()));
  for (MpmSimulation* simulation : {one.get(), again->get()}) {
    while (simulation->time() < 1.0 / 6.0 - 1e-12)
      ASSERT_TRUE(simulation->step(1.0 / 6.0));
  }
  EXPECT_EQ(one->snapshot(1).bodies.back().channels[0].values, (*again)->snapshot(1).bodies.back().channels[0].values);
  EXPECT_EQ(one->snapshot(1).bodies.back().channels[1].values, (*again)->snapshot(1).bodies.back().channels[1].values);
}

/// Sand that falls with its fields kept: frames of its grains, and what carried them to each.
struct Kept {
  std::vector<Frame> frames;
  std::vector<std::vector<GrainUpdate>> fields;
};
Kept run_and_keep(const MpmPlan& plan) {
  Kept kept;
  auto simulation = MpmSimulation::create(plan, 1, Isa::sse4);
  for (int frame = 1; frame <= 6; ++frame) {
    while ((*simulation)->time() < frame / 24.0 * (1.0 - 1e-12))
      EXPECT_TRUE((*simulation)->step(frame / 24.0));
    kept.frames.push_back((*simulation)->snapshot(frame));
    kept.fields.push_back((*simulation)->take_fields());
  }
  return kept;
}

void expect_same_grains(const Frame& a, const Frame& b) {
  for (std::size_t c = 0; c < a.bodies.back().channels.size(); ++c)
    EXPECT_EQ(a.bodies.back().channels[c].values, b.bodies.back().channels[c].values)
        << a.bodies.back().channels[c].name << " of frame " << a.number;
}

TEST(SubParticles, OfAnotherSeedComeFromKeptFieldsToTheBitsThatSimulatingGives) {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    MpmPlan plan = falling_sand();
    plan.settings.keep_fields = true;
    plan.settings.precision = precision;
    const Kept first = run_and_keep(plan);
    plan.bodies[0].sub_particles->seed = 77;
    plan.bodies[0].sub_particles->per_particle = 3;
    const Kept simulated = run_and_keep(plan);
    auto follower = MpmSimulation::create(plan, 1, Isa::sse4);
    for (std::size_t frame = 0; frame < first.fields.size(); ++frame) {
      StateArchive stored;
      archive_updates(first.fields[frame], "kept", stored);
      const Result<std::vector<GrainUpdate>> updates = restore_updates(stored, "kept");
      ASSERT_TRUE(updates) << updates.error().message;
      ASSERT_EQ(updates->size(), first.fields[frame].size());
      ASSERT_TRUE((*follower)->replay(*updates));
      expect_same_grains(simulated.frames[frame], (*follower)->snapshot(static_cast<int>(frame) + 1));
    }
  }
}

TEST(SubParticles, KeptFieldsSurviveACheckpointBetweenFrames) {
  MpmPlan plan = falling_sand();
  plan.settings.keep_fields = true;
  auto simulation = MpmSimulation::create(plan, 1, Isa::sse4);
  while ((*simulation)->time() < 0.04)
    ASSERT_TRUE((*simulation)->step(1.0 / 24.0));
  auto again = MpmSimulation::create(plan, 1, Isa::sse4);
  ASSERT_TRUE((*again)->restore((*simulation)->archive()));
  const std::vector<GrainUpdate> kept = (*simulation)->take_fields(), restored = (*again)->take_fields();
  ASSERT_FALSE(kept.empty());
  ASSERT_EQ(kept.size(), restored.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(kept[i].spans, restored[i].spans);
    EXPECT_EQ(kept[i].grid.coords, restored[i].grid.coords);
    EXPECT_EQ(kept[i].grid.occupied, restored[i].grid.occupied);
    EXPECT_EQ(kept[i].grid.values, restored[i].grid.values);
  }
}

TEST(SubParticles, WithoutKeepFieldsNoneAreKept) {
  EXPECT_TRUE(run(falling_sand(), 1.0 / 24.0)->take_fields().empty());
}

TEST(SubParticles, CostNothingWhenThereAreNone) {
  MpmPlan plan = falling_sand();
  plan.bodies[0].sub_particles.reset();
  const auto simulation = run(plan, 1.0 / 24.0);
  EXPECT_EQ(simulation->snapshot(1).bodies.size(), 1u);
  EXPECT_EQ(simulation->scene_static().bodies.size(), 1u);
  EXPECT_EQ((*simulation).step(1.0)->grain_updates, 0u);
}

TEST(SubParticles, AStepTellsHowManyItMoved) {
  MpmPlan plan = falling_sand();
  const std::size_t grains = 2 * static_cast<std::size_t>(plan.bodies[0].positions->rows());
  plan.bodies[0].sub_particles->travel = 0.0; // in every step
  auto every = MpmSimulation::create(plan, 1, Isa::sse4);
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ((*every)->step(1.0)->grain_updates, grains);
  plan.bodies[0].sub_particles->travel = 0.25;
  auto seldom = MpmSimulation::create(plan, 1, Isa::sse4);
  EXPECT_EQ((*seldom)->step(1.0)->grain_updates, 0u);
  EXPECT_EQ((*seldom)->step((*seldom)->time() + 1e-6)->grain_updates, grains) << "a frame ends";
}

} // namespace
} // namespace wry::mpm
