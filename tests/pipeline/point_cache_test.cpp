#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/assets/point_cache.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryFolder;

template <class T> void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Two samples of three points: the second one unit further along x.
std::string two_samples() {
  std::string bytes("POINTCACHE2\0", 12);
  append(bytes, std::int32_t{1});
  append(bytes, std::int32_t{3});
  append(bytes, 10.f);
  append(bytes, 2.f);
  append(bytes, std::int32_t{2});
  for (int sample = 0; sample < 2; ++sample) {
    for (int i = 0; i < 9; ++i)
      append(bytes, static_cast<float>(i + (i % 3 == 0 ? sample : 0)));
  }
  return bytes;
}

class PointCacheFile : public ::testing::Test {
protected:
  Result<PointCache> read(const std::string& bytes, int vertices = 3) const {
    std::ofstream(m_folder.path() / "a.pc2", std::ios::binary) << bytes;
    return read_point_cache(m_folder.path() / "a.pc2", vertices);
  }
  TemporaryFolder m_folder;
};

TEST_F(PointCacheFile, SamplesComeInUnitsOfTheFileWithTheirFrames) {
  const Result<PointCache> cache = read(two_samples());
  ASSERT_TRUE(cache.ok()) << cache.error().message;
  EXPECT_EQ(cache->first_frame, 10.0);
  EXPECT_EQ(cache->frames_per_sample, 2.0);
  ASSERT_EQ(cache->samples.size(), 2u);
  EXPECT_EQ(cache->samples[0](1, 0), 3.0);
  EXPECT_EQ(cache->samples[1](1, 0), 4.0);
  EXPECT_EQ(cache->samples[1](2, 2), 8.0);
}

TEST_F(PointCacheFile, HeadersThatDoNotFitAreRefused) {
  EXPECT_THAT(read(two_samples(), 4).error().message, HasSubstr("moves 3 points, the mesh has 4"));
  std::string bytes = two_samples();
  const std::int32_t many = std::numeric_limits<std::int32_t>::max();
  std::memcpy(bytes.data() + 28, &many, 4);
  EXPECT_THAT(read(bytes).error().message, HasSubstr("samples"));
  EXPECT_FALSE(read(two_samples().substr(0, 60)).ok());
  EXPECT_FALSE(read("POINTCACHE").ok());
  bytes = two_samples();
  const float nan = std::nanf("");
  std::memcpy(bytes.data() + 32, &nan, 4);
  EXPECT_THAT(read(bytes).error().message, HasSubstr("sample 0, point 0"));
  bytes = two_samples();
  std::memcpy(bytes.data() + 24, &nan, 4);
  EXPECT_FALSE(read(bytes).ok());
}

} // namespace
} // namespace wry::pipeline
