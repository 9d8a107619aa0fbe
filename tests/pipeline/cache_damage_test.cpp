#include <algorithm>
#include <cstdlib>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/cache/checkpoints.h"
#include "pipeline/cache/frame_cache.h"
#include "pipeline/cache/frame_format.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {

using namespace testing;

namespace {

/// How many damages of each kind; WRY_TEST_DAMAGES asks for more.
int damage_count() {
  const char* asked = std::getenv("WRY_TEST_DAMAGES");
  return asked == nullptr ? 300 : std::atoi(asked);
}

enum class Damage { flip, truncate, zero_page };

std::string damaged(std::string bytes, Damage kind, std::mt19937& random) {
  const std::size_t at = std::uniform_int_distribution<std::size_t>(0, bytes.size() - 1)(random);
  switch (kind) {
  case Damage::flip:
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << std::uniform_int_distribution<int>(0, 7)(random)));
    break;
  case Damage::truncate:
    bytes.resize(at);
    break;
  case Damage::zero_page: {
    const std::size_t page = at / 4096 * 4096;
    std::fill(bytes.begin() + static_cast<long>(page),
              bytes.begin() + static_cast<long>(std::min(page + 4096, bytes.size())), 0);
    break;
  }
  }
  return bytes;
}

} // namespace

class DamagedFile : public ::testing::TestWithParam<Damage> {};

/// Through the manifest, as readers do: every damage is an error that names the file.
TEST_P(DamagedFile, IsNoticedByReadersAndByTheCheck) {
  TemporaryFolder folder;
  const std::filesystem::path frames = folder.path() / "frames";
  Result<FrameCache> cache = FrameCache::open_to_write(frames, {"k", Compression::none, {}});
  ASSERT_TRUE(cache->write_frame(make_frame(1, 700)).ok());
  const std::string whole = contents(frames / "0001.h5");
  std::mt19937 random(11);
  for (int i = 0; i < damage_count(); ++i) {
    const std::string bytes = damaged(whole, GetParam(), random);
    if (bytes == whole)
      continue;
    spoil(frames / "0001.h5", bytes);
    const Result<Frame> frame = cache->read_frame(1);
    ASSERT_FALSE(frame.ok());
    EXPECT_EQ(frame.error().code, ErrorCode::io);
    EXPECT_NE(frame.error().message.find("0001.h5"), std::string::npos) << frame.error().message;
    const Result<FolderReport> report = check_folder(frames);
    ASSERT_EQ(report->findings.size(), 1u);
    EXPECT_EQ(report->findings[0].kind, FolderFinding::Kind::damaged);
  }
}

/// Past the manifest, straight into HDF5, as a file that was copied away would come: never a crash, and never another
/// value than was written. A flip that changes nothing of what is read may pass.
TEST_P(DamagedFile, IsNeverSilentlyWrongWithoutItsManifest) {
  const Frame frame = make_frame(1, 700);
  const std::string whole = *encode_frame(frame, "k", Compression::none);
  std::mt19937 random(12);
  int noticed = 0;
  int harmless = 0;
  for (int i = 0; i < damage_count(); ++i) {
    const std::string bytes = damaged(whole, GetParam(), random);
    if (bytes == whole)
      continue;
    const Result<Frame> read = decode_frame(bytes, "damaged.h5");
    noticed += !read.ok();
    harmless += read.ok();
    ASSERT_TRUE(!read.ok() || same_bits(*read, frame)) << "silent damage number " << i;
  }
  EXPECT_GT(noticed, 10 * harmless);
}

INSTANTIATE_TEST_SUITE_P(Kinds, DamagedFile, ::testing::Values(Damage::flip, Damage::truncate, Damage::zero_page));

TEST(DamagedFolder, NamesEveryMissingOrphanedAndUnfinishedFile) {
  TemporaryFolder folder;
  const std::filesystem::path frames = folder.path() / "frames";
  Result<FrameCache> cache = FrameCache::open_to_write(frames, {"k", Compression::none, {}});
  for (const int number : {1, 2, 3})
    ASSERT_TRUE(cache->write_frame(make_frame(number, 50)).ok());
  EXPECT_TRUE(check_folder(frames)->findings.empty());
  EXPECT_EQ(check_folder(frames)->good_files, 3u);
  std::filesystem::remove(frames / "0002.h5");
  spoil(frames / "0007.h5", "what is this");
  spoil(frames / "0004.h5.aside", "half");
  spoil(frames / "manifest", contents(frames / "manifest") + "have 0005.h5 12");
  const Result<FolderReport> report = check_folder(frames);
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->good_files, 2u);
  using Kind = FolderFinding::Kind;
  std::vector<std::pair<Kind, std::string>> found;
  for (const FolderFinding& finding : report->findings)
    found.emplace_back(finding.kind, finding.name);
  EXPECT_EQ(found, (std::vector<std::pair<Kind, std::string>>{{Kind::torn_manifest, "manifest"},
                                                              {Kind::missing, "0002.h5"},
                                                              {Kind::unfinished, "0004.h5.aside"},
                                                              {Kind::orphan, "0007.h5"}}));
  EXPECT_TRUE(is_damage(Kind::missing) && !is_damage(Kind::orphan));
  // The next writer repairs what a kill leaves.
  cache = FrameCache::open_to_write(frames, {"k", Compression::none, {}});
  ASSERT_TRUE(cache.ok()) << cache.error().message;
  EXPECT_EQ(check_folder(frames)->findings.size(), 2u);
}

TEST(DamagedManifest, TearsAtTheEndLoseOnlyTheLastFrameAndAreRepaired) {
  TemporaryFolder folder;
  const std::filesystem::path frames = folder.path() / "frames";
  Result<FrameCache> cache = FrameCache::open_to_write(frames, {"k", Compression::none, {}});
  for (const int number : {1, 2, 3})
    ASSERT_TRUE(cache->write_frame(make_frame(number, 20)).ok());
  const std::string whole = contents(frames / "manifest");
  const std::size_t last_line = whole.rfind('\n', whole.size() - 2) + 1;
  for (std::size_t size = last_line; size < whole.size(); ++size) {
    spoil(frames / "manifest", whole.substr(0, size));
    EXPECT_EQ(FrameCache::open_to_read(frames, "k")->frames().size(), 2u) << size;
    Result<FrameCache> writer = FrameCache::open_to_write(frames, {"k", Compression::none, {}});
    ASSERT_TRUE(writer.ok()) << writer.error().message;
    ASSERT_TRUE(writer->write_frame(make_frame(3, 20)).ok());
    EXPECT_EQ(contents(frames / "manifest"), whole) << size;
  }
  // A power cut can leave zeros where the last line should be.
  spoil(frames / "manifest", whole.substr(0, last_line) + std::string(whole.size() - last_line - 1, '\0'));
  EXPECT_EQ(FrameCache::open_to_read(frames, "k")->frames().size(), 2u);
}

TEST(DamagedManifest, EveryFlipIsAnErrorWithTheLine) {
  TemporaryFolder folder;
  const std::filesystem::path frames = folder.path() / "frames";
  Result<FrameCache> cache = FrameCache::open_to_write(frames, {"k", Compression::none, {}});
  for (const int number : {1, 2, 3})
    ASSERT_TRUE(cache->write_frame(make_frame(number, 20)).ok());
  const std::string whole = contents(frames / "manifest");
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ 4);
    spoil(frames / "manifest", flipped);
    const Result<FrameCache> read = FrameCache::open_to_read(frames, "k");
    if (at + 1 == whole.size()) {
      // Without its end the last line cannot be told from one that a kill tore.
      EXPECT_EQ(read->frames().size(), 2u);
      continue;
    }
    ASSERT_FALSE(read.ok()) << at;
    EXPECT_NE(read.error().message.find("manifest:"), std::string::npos) << read.error().message;
  }
}

} // namespace wry::pipeline
