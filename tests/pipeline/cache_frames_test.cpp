#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "pipeline/cache/checkpoints.h"
#include "pipeline/cache/frame_cache.h"
#include "pipeline/cache/frame_format.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {

using namespace testing;

namespace {

FrameCache open(const TemporaryFolder& folder, const std::string& key = "a1",
                Compression compression = Compression::none) {
  Result<FrameCache> cache = FrameCache::open_to_write(folder.path() / "frames", {key, compression, {}});
  EXPECT_TRUE(cache.ok()) << cache.error().message;
  return *std::move(cache);
}

CheckpointStore open_checkpoints(const TemporaryFolder& folder, int keep_every = 0, const std::string& key = "a1") {
  Result<CheckpointStore> store = CheckpointStore::open(folder.path() / "checkpoints", {key, keep_every, {}});
  EXPECT_TRUE(store.ok()) << store.error().message;
  return *std::move(store);
}

} // namespace

class FrameCacheCompression : public ::testing::TestWithParam<Compression> {};

TEST_P(FrameCacheCompression, GivesBackEveryBitOfAFrame) {
  TemporaryFolder folder;
  FrameCache cache = open(folder, "a1", GetParam());
  for (const int vertices : {0, 1, 7, 200'000}) {
    const Frame frame = make_frame(vertices + 1, vertices);
    const Status written = cache.write_frame(frame);
    ASSERT_TRUE(written.ok()) << written.error().message;
    const Result<Frame> read = cache.read_frame(vertices + 1);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_TRUE(same_bits(frame, *read)) << vertices;
  }
}

INSTANTIATE_TEST_SUITE_P(Both, FrameCacheCompression, ::testing::Values(Compression::none, Compression::deflate));

TEST(FrameCache, GivesBackTheStaticScene) {
  TemporaryFolder folder;
  FrameCache cache = open(folder);
  const SceneStatic scene = make_static();
  EXPECT_FALSE(cache.has_static());
  ASSERT_TRUE(cache.write_static(scene).ok());
  EXPECT_TRUE(cache.has_static());
  const Result<SceneStatic> read = cache.read_static();
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->bodies.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read->bodies[i].name, scene.bodies[i].name);
    EXPECT_EQ(read->bodies[i].kind, scene.bodies[i].kind);
    EXPECT_EQ(read->bodies[i].grain.shape, scene.bodies[i].grain.shape);
    EXPECT_EQ(read->bodies[i].grain.size, scene.bodies[i].grain.size);
    EXPECT_EQ(read->bodies[i].look, scene.bodies[i].look);
    EXPECT_EQ(read->bodies[i].simulated, scene.bodies[i].simulated);
    EXPECT_EQ(read->bodies[i].rest_positions, scene.bodies[i].rest_positions);
    EXPECT_EQ(read->bodies[i].tets, scene.bodies[i].tets);
    EXPECT_EQ(read->bodies[i].triangles, scene.bodies[i].triangles);
  }
}

TEST(FrameCache, TheSameFrameIsTheSameBytesAtAnyTime) {
  TemporaryFolder folder;
  FrameCache cache = open(folder);
  ASSERT_TRUE(cache.write_frame(make_frame(1, 300'000)).ok());
  const std::string first = contents(folder.path() / "frames" / "0001.h5");
  // HDF5's time stamps are whole seconds.
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  for (int again = 0; again < 4; ++again)
    ASSERT_TRUE(cache.write_frame(make_frame(1, 300'000)).ok());
  EXPECT_TRUE(first == contents(folder.path() / "frames" / "0001.h5"));
}

TEST(FrameCache, StoresFloat32WhereTheChannelSaysSo) {
  TemporaryFolder folder;
  FrameCache cache = open(folder);
  Frame frame = make_frame(1, 4);
  frame.bodies[0].channels = {{"third", ChannelOn::vertex, 1, ChannelStorage::float32, {1.0 / 3.0}}};
  ASSERT_TRUE(cache.write_frame(frame).ok());
  EXPECT_EQ(cache.read_frame(1)->bodies[0].channels[0].values[0], static_cast<double>(1.0f / 3.0f));
  frame.bodies[0].channels[0].values[0] = 1e39;
  const Status too_large = cache.write_frame(frame);
  ASSERT_FALSE(too_large.ok());
  EXPECT_NE(too_large.error().message.find("float64"), std::string::npos) << too_large.error().message;
  EXPECT_TRUE(cache.has_frame(1)) << "the frame that could not be replaced is still there";
}

TEST(FrameCache, AnArrayThatIsALittleLongerThanAChunkTakesLittleMoreThanItsValues) {
  Frame frame;
  frame.number = 1;
  FrameBody body;
  body.name = "bar";
  body.channels.push_back({"point_rotation", ChannelOn::tet, 16, ChannelStorage::float64, {}});
  body.channels.back().values.assign(std::size_t{9000} * 16, 0.5); // 1.1 MiB
  frame.bodies.push_back(body);
  const Result<std::string> bytes = encode_frame(frame, "a1", Compression::none);
  ASSERT_TRUE(bytes.ok()) << bytes.error().message;
  EXPECT_LT(bytes->size(), std::size_t{9000} * 16 * 8 * 105 / 100);
}

TEST(FrameCache, RefusesChannelsThatAreNoRows) {
  TemporaryFolder folder;
  FrameCache cache = open(folder);
  Frame frame = make_frame(3, 4);
  frame.bodies[0].channels[0].values.pop_back();
  const Status torn = cache.write_frame(frame);
  ASSERT_FALSE(torn.ok());
  EXPECT_EQ(torn.error().code, ErrorCode::bad_input);
  EXPECT_NE(torn.error().message.find("frame 3"), std::string::npos) << torn.error().message;
  EXPECT_NE(torn.error().message.find("position"), std::string::npos) << torn.error().message;
  EXPECT_FALSE(cache.has_frame(3));
}

TEST(FrameCache, ListsFramesByNumberAndOnlyThoseOfItsKey) {
  TemporaryFolder folder;
  {
    FrameCache old = open(folder, "old");
    for (const int number : {1, 2, 3})
      ASSERT_TRUE(old.write_frame(make_frame(number, 4)).ok());
  }
  FrameCache cache = open(folder, "new");
  EXPECT_TRUE(cache.frames().empty());
  EXPECT_EQ(cache.stale_frames().size(), 3u);
  ASSERT_TRUE(cache.write_frame(make_frame(12, 4)).ok());
  ASSERT_TRUE(cache.write_frame(make_frame(2, 5)).ok());
  ASSERT_EQ(cache.frames().size(), 2u);
  EXPECT_EQ(cache.frames()[0].number, 2);
  EXPECT_EQ(cache.frames()[1].number, 12);
  ASSERT_EQ(cache.stale_frames().size(), 2u);
  EXPECT_EQ(cache.stale_frames()[1].number, 3);
  EXPECT_EQ(cache.stale_frames()[1].key, "old");
  const Result<Frame> stale = cache.read_frame(3);
  ASSERT_FALSE(stale.ok());
  EXPECT_EQ(stale.error().code, ErrorCode::missing_input);
  EXPECT_NE(stale.error().message.find("other inputs"), std::string::npos) << stale.error().message;
  const Result<FrameCache> any = FrameCache::open_to_read(folder.path() / "frames");
  EXPECT_EQ(any->frames().size(), 4u);
}

TEST(FrameCache, MissingFramesAndFoldersAre66) {
  TemporaryFolder folder;
  EXPECT_EQ(FrameCache::open_to_read(folder.path() / "nowhere").error().code, ErrorCode::missing_input);
  FrameCache cache = open(folder);
  const Result<Frame> missing = cache.read_frame(5);
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::missing_input);
  EXPECT_NE(missing.error().message.find("frame 5"), std::string::npos);
}

TEST(FrameCache, ForgetsWhatIsDiscarded) {
  TemporaryFolder folder;
  FrameCache cache = open(folder);
  ASSERT_TRUE(cache.write_static(make_static()).ok());
  for (const int number : {1, 2, 3, 4})
    ASSERT_TRUE(cache.write_frame(make_frame(number, 4)).ok());
  ASSERT_TRUE(cache.discard_after(2).ok());
  EXPECT_EQ(open(folder).frames().size(), 2u);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "frames" / "0003.h5"));
  EXPECT_TRUE(cache.has_static());
  ASSERT_TRUE(cache.discard_all().ok());
  EXPECT_FALSE(open(folder).has_static());
}

TEST(FrameCache, AReaderSeesNewFramesAfterRefreshAndReplacedOnesAtOnce) {
  TemporaryFolder folder;
  FrameCache writer = open(folder);
  ASSERT_TRUE(writer.write_frame(make_frame(1, 4)).ok());
  Result<FrameCache> reader = FrameCache::open_to_read(folder.path() / "frames", "a1");
  ASSERT_TRUE(writer.write_frame(make_frame(2, 4)).ok());
  EXPECT_FALSE(reader->has_frame(2));
  ASSERT_TRUE(reader->refresh().ok());
  EXPECT_TRUE(reader->has_frame(2));
  ASSERT_TRUE(writer.write_frame(make_frame(1, 9)).ok());
  const Result<Frame> replaced = reader->read_frame(1);
  ASSERT_TRUE(replaced.ok()) << replaced.error().message;
  EXPECT_TRUE(same_bits(*replaced, make_frame(1, 9)));
}

TEST(Checkpoints, GiveBackEveryBit) {
  TemporaryFolder folder;
  CheckpointStore store = open_checkpoints(folder);
  ASSERT_TRUE(store.write(make_state(7), 7, 0.25).ok());
  const Result<CheckpointStore::Found> found = store.latest_at_or_before(100);
  ASSERT_TRUE(found.ok() && found->checkpoint);
  EXPECT_EQ(found->checkpoint->frame, 7);
  EXPECT_EQ(found->checkpoint->time, 0.25);
  EXPECT_TRUE(same_bits(found->checkpoint->state, make_state(7)));
  EXPECT_FALSE(store.latest_at_or_before(6)->checkpoint);
}

TEST(Checkpoints, KeepTheLastTwoAndEveryNth) {
  TemporaryFolder folder;
  CheckpointStore store = open_checkpoints(folder, 10);
  for (int frame = 1; frame <= 25; ++frame)
    ASSERT_TRUE(store.write(make_state(frame), frame, frame / 24.0).ok());
  EXPECT_EQ(store.frames(), (std::vector<int>{10, 20, 24, 25}));
  EXPECT_EQ(open_checkpoints(folder).latest_at_or_before(23)->checkpoint->frame, 20);
}

TEST(Checkpoints, KeepWhatWasJustWrittenAfterGoingBack) {
  TemporaryFolder folder;
  CheckpointStore store = open_checkpoints(folder);
  for (const int frame : {50, 60, 20})
    ASSERT_TRUE(store.write(make_state(frame), frame, frame / 24.0).ok());
  EXPECT_EQ(store.frames(), (std::vector<int>{20, 60}));
}

TEST(Checkpoints, OfOtherInputsAreTakenOnlyWhenAskedFor) {
  TemporaryFolder folder;
  ASSERT_TRUE(open_checkpoints(folder, 10, "old").write(make_state(30), 30, 1.25).ok());
  CheckpointStore store = open_checkpoints(folder, 10, "new");
  EXPECT_FALSE(store.latest_at_or_before(40)->checkpoint);
  const Result<CheckpointStore::Found> old = store.latest_at_or_before(40, CheckpointKey::any);
  ASSERT_TRUE(old->checkpoint);
  EXPECT_EQ(old->key, "old");
}

TEST(Checkpoints, FallBackWithAWarningWhenTheLastIsDamaged) {
  TemporaryFolder folder;
  CheckpointStore store = open_checkpoints(folder);
  for (const int frame : {8, 9})
    ASSERT_TRUE(store.write(make_state(frame), frame, frame / 24.0).ok());
  const std::filesystem::path last = folder.path() / "checkpoints" / "0009.h5";
  std::string bytes = contents(last);
  bytes[bytes.size() / 2] ^= 1;
  spoil(last, bytes);
  const Result<CheckpointStore::Found> found = store.latest_at_or_before(9);
  ASSERT_TRUE(found->checkpoint);
  EXPECT_EQ(found->checkpoint->frame, 8);
  ASSERT_EQ(found->warnings.size(), 1u);
  EXPECT_NE(found->warnings[0].find("0009.h5"), std::string::npos) << found->warnings[0];
  spoil(folder.path() / "checkpoints" / "0008.h5", "");
  EXPECT_FALSE(store.latest_at_or_before(9)->checkpoint);
  EXPECT_EQ(store.latest_at_or_before(9)->warnings.size(), 2u);
}

} // namespace wry::pipeline
