#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/environment.h"
#include "render/exr.h"

namespace wry::render {
namespace {

using ::testing::HasSubstr;

LinearImage even(int width, float value) {
  return {width, width / 2,
          std::vector<float>(static_cast<std::size_t>(width) * static_cast<std::size_t>(width / 2) * 4, value)};
}

std::filesystem::path scratch(const std::string& name) {
  return std::filesystem::path(::testing::TempDir()) / name;
}

void write(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

TEST(Environment, EvenSurroundingsLightAndMirrorEvenly) {
  const EnvironmentMaps maps = make_environment_maps(even(256, 0.7f), std::nullopt);
  for (const Eigen::Vector3f& direction :
       {Eigen::Vector3f(0, 1, 0), Eigen::Vector3f(1, 0, 0), Eigen::Vector3f(0, 0, -1), Eigen::Vector3f(.6f, -.8f, 0)})
    EXPECT_NEAR(matt_light(maps, direction)[1], 0.7f, 0.004f);
  ASSERT_EQ(maps.mirrored.size(), static_cast<std::size_t>(MIRROR_WIDTH * MIRROR_HEIGHT * MIRROR_LEVELS));
  for (const std::array<float, 4>& pixel : maps.mirrored)
    EXPECT_NEAR(pixel[0], 0.7f, 1e-4f);
}

/// A sky that is bright in proportion to the cosine from straight up lights a level floor with 2/3 of its zenith.
TEST(Environment, CosineSkyGivesTwoThirdsOnTheFloor) {
  LinearImage sky = even(256, 0.f);
  for (int y = 0; y < sky.height / 2; ++y) {
    const float cosine = static_cast<float>(std::cos(std::numbers::pi * (y + 0.5) / sky.height));
    for (int x = 0; x < sky.width; ++x)
      std::fill_n(sky.pixels.begin() + 4 * (y * sky.width + x), 3, cosine);
  }
  const EnvironmentMaps maps = make_environment_maps(sky, std::nullopt);
  EXPECT_NEAR(matt_light(maps, Eigen::Vector3f::UnitY())[0], 2.f / 3.f, 0.03f); // degree 2 alone: 3 % short or over
}

TEST(Environment, LightFromBelowReplacesThePicturesLowerHalf) {
  const EnvironmentMaps maps = make_environment_maps(even(128, 1.f), Eigen::Vector3f(.2f, .1f, 0.f));
  EXPECT_NEAR(matt_light(maps, -Eigen::Vector3f::UnitY())[0], .2f, .06f);
  EXPECT_NEAR(matt_light(maps, Eigen::Vector3f::UnitY())[0], 1.f, .06f);
}

TEST(Environment, SunLeavesThePictureAndKeepsItsLightAndPlace) {
  LinearImage sky = even(512, 0.2f);
  const double elevation = 40.0 * std::numbers::pi / 180.0;
  const double azimuth = 70.0 * std::numbers::pi / 180.0;
  const Vec3 sun(std::cos(elevation) * std::sin(azimuth), std::sin(elevation), std::cos(elevation) * std::cos(azimuth));
  double light = 0.0;
  for (int y = 0; y < sky.height; ++y) {
    for (int x = 0; x < sky.width; ++x) {
      const double polar = std::numbers::pi * (y + 0.5) / sky.height;
      const double turn = 2.0 * std::numbers::pi * ((x + 0.5) / sky.width - 0.5);
      const Vec3 d(std::sin(polar) * std::sin(turn), std::cos(polar), std::sin(polar) * std::cos(turn));
      if (d.dot(sun) < std::cos(1.5 * std::numbers::pi / 180.0))
        continue;
      std::fill_n(sky.pixels.begin() + 4 * (y * sky.width + x), 3, 2000.f);
      light += 2000.0 * 2.0 * std::numbers::pi * std::numbers::pi / (sky.width * sky.height) * std::sin(polar);
    }
  }
  const Result<Rig> rig = image_rig(sky);
  ASSERT_TRUE(rig.ok()) << rig.error().message;
  ASSERT_EQ(rig->lights.size(), 1U);
  EXPECT_NEAR(rig->lights[0].azimuth_degrees, 70.0, 0.7);
  EXPECT_NEAR(rig->lights[0].elevation_degrees, 40.0, 0.7);
  EXPECT_NEAR(static_cast<double>(rig->lights[0].radiance[0]), light / std::numbers::pi, 0.05 * light);
  EXPECT_NEAR(rig->sky[0], 0.2f, 0.06f);
  EXPECT_EQ(rig->lights[0].shadow, Light::Shadow::mapped);
}

TEST(Environment, RefusesPicturesThatAreNoSurroundings) {
  LinearImage square{64, 64, std::vector<float>(64 * 64 * 4, 1.f)};
  EXPECT_FALSE(image_rig(square).ok());
  LinearImage broken = even(64, 1.f);
  broken.pixels[4 * 100] = std::numeric_limits<float>::quiet_NaN();
  const Result<Rig> rig = image_rig(broken);
  ASSERT_FALSE(rig.ok());
  EXPECT_THAT(rig.error().message, HasSubstr("pixel 100"));
  EXPECT_FALSE(image_rig(even(64, 0.f)).ok());
}

TEST(LightImage, ReadsRadianceInRunsAndPlain) {
  // 8 x 4; each line: planes r, g, b, e in runs. 128, 64, 32 with exponent 129: 1, 0.5, 0.25.
  std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n";
  for (int y = 0; y < 4; ++y) {
    bytes += std::string("\x02\x02\x00\x08", 4);
    for (const unsigned char value : {128, 64, 32, 129})
      bytes += std::string("\x88", 1) + static_cast<char>(value);
  }
  const auto path = scratch("runs.hdr");
  write(path, bytes);
  const Result<LinearImage> image = read_light_image(path);
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(image->width, 8);
  EXPECT_FLOAT_EQ(image->at(7, 3)[0], 1.f);
  EXPECT_FLOAT_EQ(image->at(7, 3)[2], .25f);
  write(path, bytes.substr(0, bytes.size() - 3));
  EXPECT_EQ(read_light_image(path).error().code, ErrorCode::bad_input);
  write(path, "GIF89a");
  EXPECT_THAT(read_light_image(path).error().message, HasSubstr("neither"));
  EXPECT_EQ(read_light_image(scratch("nowhere.hdr")).error().code, ErrorCode::missing_input);
}

TEST(Exr, ComesBackWithItsLayersTypesAndTexts) {
  ExrImage image{5, 3, {}, {{"wryInputs", "abc"}}};
  for (const auto& [name, type] :
       {std::pair("R", ExrChannel::Type::half_float), std::pair("Z", ExrChannel::Type::float32),
        std::pair("id", ExrChannel::Type::integer)}) {
    ExrChannel channel{name, type, {}};
    for (int i = 0; i < 15; ++i)
      channel.values.push_back(static_cast<float>(i) * (type == ExrChannel::Type::float32 ? 1.001f : 1.f));
    image.channels.push_back(channel);
  }
  const auto path = scratch("layers.exr");
  ASSERT_TRUE(write_exr(path, image).ok());
  const Result<ExrImage> read = read_exr(path);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->channels.size(), 3U);
  for (const ExrChannel& channel : read->channels) {
    const ExrChannel& original = image.channels[channel.name == "R" ? 0 : channel.name == "Z" ? 1 : 2];
    EXPECT_EQ(channel.name, original.name);
    EXPECT_EQ(channel.type, original.type);
    EXPECT_EQ(channel.values, original.values);
  }
  EXPECT_THAT(read->texts, ::testing::Contains(std::pair<std::string, std::string>("wryInputs", "abc")));
  EXPECT_THAT(read->texts, ::testing::Contains(std::pair<std::string, std::string>("colorspace", "lin_rec709")));
}

TEST(Exr, DamagedFilesAreRefused) {
  const auto path = scratch("damaged.exr");
  write(path, std::string("\x76\x2f\x31\x01", 4) + "rubbish");
  EXPECT_EQ(read_exr(path).error().code, ErrorCode::bad_input);
  EXPECT_EQ(read_exr(scratch("none.exr")).error().code, ErrorCode::missing_input);
}

} // namespace
} // namespace wry::render
