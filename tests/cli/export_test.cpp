#include <algorithm>
#include <cstring>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/cache/frame_cache.h"
#include "tests/cli/program_support.h"
#include "tests/cli/slurm_support.h"

namespace wry::cli_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Export : public testing::Test {
protected:
  void SetUp() override {
    write_text(m_folder.path() / "bar.toml", small_shot());
    ASSERT_EQ(run_wry({"simulate", "bar.toml", "--out", "o", "--frames", "1-3"}, m_folder.path()).exit_code, 0);
  }
  Outcome export_to(const std::string& formats, std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"export", "bar.toml", "--out", "o", "--frames", "1-3", "--to", formats};
    words.insert(words.end(), more.begin(), more.end());
    return run_wry(words, m_folder.path());
  }
  fs::path exports() const { return m_folder.path() / "o" / "exports"; }
  /// Positions of the bar as the cache has them.
  std::vector<double> cached(int frame) const {
    const Result<pipeline::FrameCache> cache = pipeline::FrameCache::open_to_read(m_folder.path() / "o" / "frames");
    return find_channel(cache->read_frame(frame)->bodies.at(0), "position")->values;
  }
  const TemporaryFolder m_folder;
};

template <class T> T number_at(const std::string& bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

TEST_F(Export, Pc2HoldsEverySampleAsItsSpecificationSays) {
  ASSERT_EQ(export_to("pc2").exit_code, 0);
  const std::string bytes = read_text(exports() / "pc2" / "bar.pc2");
  ASSERT_GT(bytes.size(), 32u);
  EXPECT_EQ(bytes.substr(0, 12), std::string("POINTCACHE2\0", 12));
  EXPECT_EQ(number_at<std::int32_t>(bytes, 12), 1);
  const auto points = static_cast<std::size_t>(number_at<std::int32_t>(bytes, 16));
  EXPECT_EQ(number_at<float>(bytes, 20), 1.f) << "first frame";
  EXPECT_EQ(number_at<float>(bytes, 24), 1.f) << "frames per sample";
  ASSERT_EQ(number_at<std::int32_t>(bytes, 28), 3);
  ASSERT_EQ(bytes.size(), 32 + 3 * points * 3 * sizeof(float));
  for (int frame = 1; frame <= 3; ++frame) {
    const std::vector<double> expected = cached(frame);
    ASSERT_EQ(expected.size(), 3 * points);
    for (std::size_t i = 0; i < expected.size(); ++i)
      ASSERT_EQ(number_at<float>(bytes, 32 + (static_cast<std::size_t>(frame - 1) * 3 * points + i) * 4),
                static_cast<float>(expected[i]));
  }
  EXPECT_THAT(read_text(exports() / "pc2" / "bar.obj"), HasSubstr("\nf "));
  const Outcome uneven =
      run_wry({"export", "bar.toml", "--out", "o", "--frames", "1,3", "--to", "pc2"}, m_folder.path());
  EXPECT_EQ(uneven.exit_code, 0) << "two samples are evenly spaced";
}

TEST_F(Export, UsdaSaysUnitsAxesAndRatesAndHasASamplePerFrame) {
  ASSERT_EQ(export_to("usda").exit_code, 0);
  const std::string text = read_text(exports() / "usda" / "bar.usda");
  for (const char* part : {"#usda 1.0", "metersPerUnit = 1", "upAxis = \"Y\"", "timeCodesPerSecond = 24",
                           "startTimeCode = 1", "endTimeCode = 3", "def Mesh \"bar\"", "point3f[] points.timeSamples",
                           "vector3f[] velocities.timeSamples", "subdivisionScheme = \"none\""})
    EXPECT_THAT(text, HasSubstr(part));
  const std::size_t first = text.find("points.timeSamples");
  const std::string samples = text.substr(first, text.find("velocities.timeSamples") - first);
  EXPECT_EQ(static_cast<std::size_t>(std::count(samples.begin(), samples.end(), '(')), cached(1).size());
}

TEST_F(Export, XdmfNamesArraysThatAreInTheCache) {
  ASSERT_EQ(export_to("xdmf").exit_code, 0);
  const std::string text = read_text(exports() / "xdmf" / "bar.xdmf");
  EXPECT_THAT(text, HasSubstr("../../frames/0002.h5:/bodies/0000/channels/position"));
  EXPECT_THAT(text, HasSubstr("../../frames/static.h5:/bodies/0000/tets"));
  EXPECT_TRUE(fs::exists(exports() / "xdmf" / "../../frames/0002.h5"));
}

TEST_F(Export, WhatCannotBeHadIsSaidSo) {
  const Outcome alembic = export_to("abc");
  EXPECT_EQ(alembic.exit_code, 2);
  EXPECT_THAT(alembic.err, HasSubstr("usda"));
  const Outcome later = run_wry({"export", "bar.toml", "--out", "o", "--to", "obj"}, m_folder.path());
  EXPECT_EQ(later.exit_code, 66);
  EXPECT_THAT(later.err, HasSubstr("frame 4"));
}

} // namespace
} // namespace wry::cli_test
