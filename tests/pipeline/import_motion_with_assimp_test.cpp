#include "pipeline/assets/motion_import.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/pipeline/import_files_support.h"

namespace wry::pipeline {
namespace {

constexpr double PI = std::numbers::pi;

/// A glTF file: a truck that drives 2 m along x in two seconds while its bed tips 60 degrees about x, a camera that
/// stands 5 m before it, and a wheel without animation below the truck. The bed is a triangle.
class AnimatedTruck {
public:
  explicit AnimatedTruck(const std::string& extra_scale = "") {
    const double h = 30.0 * PI / 180.0; // half of 60 degrees
    const int positions = add({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int times = add({0, 2});
    const int drive = add({0, 0, 0, 2, 0, 0});
    const int tip = add({0, 0, 0, 1, static_cast<float>(std::sin(h)), 0, 0, static_cast<float>(std::cos(h))});
    const auto accessor = [&](int view, int count, const char* type, const char* bounds = "") {
      return fmt::format(R"({{"bufferView":{},"componentType":5126,"count":{},"type":"{}"{}}})", view, count, type,
                         bounds);
    };
    m_json = fmt::format(
        R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,2]}}],)"
        R"("nodes":[{{"name":"truck","translation":[0,0,1]{},"children":[1,3]}},)"
        R"({{"name":"bed","translation":[0,0.5,0],"mesh":0}},)"
        R"({{"name":"shot_camera","translation":[0,1,5],"camera":0}},{{"name":"wheel","mesh":0}}],)"
        R"("cameras":[{{"type":"perspective","perspective":{{"yfov":0.6,"aspectRatio":1.5,"znear":0.1}}}}],)"
        R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],)"
        R"("accessors":[{},{},{},{}],)"
        R"("animations":[{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}},)"
        R"({{"sampler":1,"target":{{"node":1,"path":"rotation"}}}}],)"
        R"("samplers":[{{"input":1,"output":2}},{{"input":1,"output":3}}]}}],)"
        R"("bufferViews":[{}],"buffers":[{{"byteLength":{},"uri":"truck.bin"}}]}})",
        extra_scale, accessor(positions, 3, "VEC3", R"(,"min":[0,0,0],"max":[1,1,0])"),
        accessor(times, 2, "SCALAR", R"(,"min":[0],"max":[2])"), accessor(drive, 2, "VEC3"), accessor(tip, 2, "VEC4"),
        m_views, m_buffer.size());
  }

  std::string write(const TemporaryFolder& folder) const {
    folder.write("truck.bin", m_buffer);
    return folder.write("truck.gltf", m_json);
  }

private:
  int add(const std::vector<float>& values) {
    const std::size_t at = m_buffer.size();
    m_buffer.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
    m_views += fmt::format(R"({}{{"buffer":0,"byteOffset":{},"byteLength":{}}})", m_views.empty() ? "" : ",", at,
                           values.size() * sizeof(float));
    return m_count++;
  }

  std::string m_json, m_views, m_buffer;
  int m_count = 0;
};

MeshImportOptions options_for(const std::string& node) {
  MeshImportOptions options;
  options.node = node;
  return options;
}

TEST(ImportMotion, ANodeMovesWithAllThatIsAboveIt) {
  const TemporaryFolder folder;
  const Result<ImportedMotion> imported = import_motion(AnimatedTruck().write(folder), options_for("bed"));
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_FALSE(imported->camera_fov);
  EXPECT_LT((imported->rest.translation - Vec3(0, 0.5, 1)).norm(), 1e-6);
  const Result<scene::Motion> motion = imported->relative_motion();
  ASSERT_TRUE(motion) << motion.error().message;
  EXPECT_NEAR(motion->last_time(), 2.0, 1e-6);
  // A corner of the bed, one metre along z from its hinge, at half time: the truck is 1 m on and, since its animation
  // puts it at z = 0, 1 m back; the bed has turned 30 degrees.
  for (const double time : {0.0, 0.37, 1.0, 1.61, 2.0}) {
    const double angle = time / 2.0 * PI / 3.0;
    const Vec3 expected(time, 0.5 - std::sin(angle), std::cos(angle));
    EXPECT_LT((motion->pose(time).apply(Vec3(0, 0.5, 2)) - expected).norm(), 1e-5) << time;
  }
  EXPECT_NEAR(motion->twist(1.0).angular.x(), PI / 6.0, 1e-4);
}

TEST(ImportMotion, UnitsAndAxesApply) {
  const TemporaryFolder folder;
  MeshImportOptions options = options_for("bed");
  options.metres_per_unit = 0.01;
  options.scene_up = geometry::Axis::z;
  const Result<ImportedMotion> imported = import_motion(AnimatedTruck().write(folder), options);
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_LT((imported->rest.translation - 0.01 * Vec3(0, -1, 0.5)).norm(), 1e-8);
}

TEST(ImportMotion, TheFirstCameraIsTakenWithoutAName) {
  const TemporaryFolder folder;
  const Result<ImportedMotion> imported = import_motion(AnimatedTruck().write(folder), options_for(""));
  ASSERT_TRUE(imported) << imported.error().message;
  ASSERT_TRUE(imported->camera_fov);
  EXPECT_NEAR(*imported->camera_fov, 2.0 * std::atan(1.5 * std::tan(0.3)), 1e-4);
  EXPECT_LT((imported->rest.translation - Vec3(0, 1, 5)).norm(), 1e-6);
  EXPECT_LT((imported->rest.rotation - Mat3::Identity()).norm(), 1e-6);
}

TEST(ImportMotion, WhatStandsStillOrIsNotThereIsSaid) {
  const TemporaryFolder folder;
  const std::string path = AnimatedTruck().write(folder);
  const Result<ImportedMotion> still = import_motion(path, options_for("shot_camera"));
  ASSERT_TRUE(still) << still.error().message;
  const Result<scene::Motion> motion = still->relative_motion();
  ASSERT_FALSE(motion);
  EXPECT_NE(motion.error().message.find("nothing moves it"), std::string::npos);
  const Result<ImportedMotion> missing = import_motion(path, options_for("crane"));
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::bad_input);
  EXPECT_NE(missing.error().message.find("truck"), std::string::npos) << missing.error().message;
}

TEST(ImportMotion, EvenScaleIsLeftAsideAndStretchingIsRefused) {
  const TemporaryFolder folder;
  const Result<ImportedMotion> even =
      import_motion(AnimatedTruck(R"(,"scale":[2,2,2])").write(folder), options_for("bed"));
  ASSERT_TRUE(even) << even.error().message;
  EXPECT_LT((even->rest.translation - Vec3(0, 1, 1)).norm(), 1e-6);
  const Result<ImportedMotion> uneven =
      import_motion(AnimatedTruck(R"(,"scale":[1,3,1])").write(folder), options_for("bed"));
  ASSERT_FALSE(uneven);
  EXPECT_NE(uneven.error().message.find("rigid"), std::string::npos) << uneven.error().message;
}

} // namespace
} // namespace wry::pipeline
