#include "pipeline/study/accuracy_errors.h"

#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "pipeline/cache/frame_cache.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {
namespace {

using testing::TemporaryFolder;

/// A run of one frame: a tet that is stretched along x, and a cloud of particles on a lattice that is moved.
StudyRow run_of(const std::filesystem::path& folder, double stretch, double way, int particles) {
  SceneStatic scene;
  scene.bodies.resize(2);
  scene.bodies[0].name = "tet";
  scene.bodies[0].rest_positions.resize(4, 3);
  scene.bodies[0].rest_positions << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  scene.bodies[0].tets.resize(1, 4);
  scene.bodies[0].tets << 0, 1, 2, 3;
  scene.bodies[0].triangles.resize(1, 3);
  scene.bodies[0].triangles << 0, 2, 1;
  scene.bodies[1].name = "cloud";
  scene.bodies[1].kind = BodyKind::particles;
  Frame frame;
  frame.number = 1;
  frame.bodies.resize(2);
  frame.bodies[0].name = "tet";
  frame.bodies[0].channels = {
      {"position", ChannelOn::vertex, 3, ChannelStorage::float64, {0, 0, 0, stretch, 0, 0, 0, 1, 0, 0, 0, 1}}};
  frame.bodies[1].name = "cloud";
  Channel cloud{"position", ChannelOn::particle, 3, ChannelStorage::float64, {}};
  for (int i = 0; i < particles; ++i)
    cloud.values.insert(cloud.values.end(), {way + (i + 0.5) / particles, 0.1, 0.1});
  frame.bodies[1].channels = {cloud};
  Result<FrameCache> cache = FrameCache::open_to_write(folder / "frames", {"k", Compression::none, {}});
  EXPECT_TRUE(cache.ok());
  EXPECT_TRUE(cache->write_static(scene).ok());
  EXPECT_TRUE(cache->write_frame(frame).ok());
  StudyRow row;
  row.folder = folder;
  row.frames = {1};
  return row;
}

double error_of(const std::string& quantity, const StudyRow& row, const StudyRow& reference) {
  for (const ErrorValue& value : errors_of_frames(row, reference)) {
    if (value.quantity == quantity)
      return value.error;
  }
  return -1.0;
}

TEST(AccuracyErrors, VolumesAreThoseOfTheTetsAndDensitiesDoNotAskForAsManyParticles) {
  const TemporaryFolder folder;
  const StudyRow exact = run_of(folder.path() / "exact", 1.0, 0.0, 4096);
  const StudyRow same = run_of(folder.path() / "same", 1.0, 0.0, 4096);
  const StudyRow coarse = run_of(folder.path() / "coarse", 1.02, 0.0, 512);
  const StudyRow away = run_of(folder.path() / "away", 1.0, 5.0, 4096);
  const StudyRow half = run_of(folder.path() / "half", 1.0, 0.5, 4096);
  for (const char* quantity : {"position", "volume", "density"})
    EXPECT_EQ(error_of(quantity, same, exact), 0.0) << quantity;
  EXPECT_NEAR(error_of("volume", coarse, exact), 0.02, 1e-12);
  EXPECT_TRUE(std::isnan(error_of("position", coarse, exact))) << "other particles have no partner";
  EXPECT_LT(error_of("density", coarse, exact), 0.01) << "the same matter in fewer pieces";
  EXPECT_NEAR(error_of("density", away, exact), 1.0, 1e-12) << "nothing is where it was";
  EXPECT_NEAR(error_of("density", half, exact), 0.5, 0.01);
  EXPECT_TRUE(std::isnan(error_of("rotation", same, exact)));
}

TEST(AccuracyErrors, EnergiesAreComparedWhereBothRunsStopped) {
  const TemporaryFolder folder;
  const StudyRow exact = run_of(folder.path() / "exact", 1.0, 0.0, 8);
  const StudyRow coarse = run_of(folder.path() / "coarse", 1.0, 0.0, 8);
  std::ofstream(exact.folder / "stats.csv")
      << "step,time_s,kinetic_energy_J,gravity_energy_J\n1,0.1,1,9\n2,0.2,2,8\n3,0.3,5,5\n4,0.4,10,0\n";
  std::ofstream(coarse.folder / "stats.csv")
      << "step,time_s,kinetic_energy_J,gravity_energy_J\n1,0.2,2,8.9\n2,0.4,10,0.9\n";
  EXPECT_NEAR(error_of("energy", coarse, exact), 0.1, 1e-12) << "0.9 J of the 9 J that changed hands";
}

} // namespace
} // namespace wry::pipeline
