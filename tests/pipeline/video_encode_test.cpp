#include <array>
#include <cstdio>
#include <memory>

#include <gtest/gtest.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/run/video.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {

using namespace testing;

namespace {

std::string output_of(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
  std::string text;
  std::array<char, 4096> buffer{};
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe.get()))
    text.append(buffer.data(), count);
  return text;
}

/// Grey pictures of 65 x 49, so that both sides are odd.
std::vector<std::filesystem::path> make_pictures(const TemporaryFolder& folder, int count) {
  std::vector<std::filesystem::path> pictures;
  for (int i = 0; i < count; ++i) {
    const std::filesystem::path path = folder.path() / fmt::format("a picture {:04}.png", 3 * i);
    output_of(fmt::format(
        "ffmpeg -loglevel error -f lavfi -i color=c=0x{0:02x}{0:02x}{0:02x}:s=65x49:d=1 -frames:v 1 -y '{1}'", 40 * i,
        path.string()));
    pictures.push_back(path);
  }
  return pictures;
}

} // namespace

TEST(Video, IsTaggedAndHasEveryPicture) {
  ASSERT_TRUE(has_video_program()) << "ffmpeg is in packages.txt";
  TemporaryFolder folder;
  const std::vector<std::filesystem::path> pictures = make_pictures(folder, 5);
  const std::filesystem::path film = folder.path() / "-film of it.mp4";
  const Status made = encode_video(pictures, film, {.fps = 12.5});
  ASSERT_TRUE(made.ok()) << made.error().message;
  const std::string facts =
      output_of(fmt::format("ffprobe -loglevel error -count_frames -show_streams -of flat 'file:{}'", film.string()));
  for (const char* expected :
       {"nb_read_frames=\"5\"", "pix_fmt=\"yuv420p\"", "color_space=\"bt709\"", "color_primaries=\"bt709\"",
        "color_transfer=\"bt709\"", "color_range=\"tv\"", "width=64", "height=48", "r_frame_rate=\"25/2\""})
    EXPECT_NE(facts.find(expected), std::string::npos) << expected << "\n" << facts;
  EXPECT_FALSE(std::filesystem::exists(aside_of(film)));
}

TEST(Video, IsTheSameBytesTwice) {
  TemporaryFolder folder;
  const std::vector<std::filesystem::path> pictures = make_pictures(folder, 4);
  for (const char* name : {"a.mp4", "b.mp4"})
    ASSERT_TRUE(encode_video(pictures, folder.path() / name, {}).ok());
  EXPECT_EQ(contents(folder.path() / "a.mp4"), contents(folder.path() / "b.mp4"));
}

TEST(Video, SaysWhenThereIsNoProgram) {
  TemporaryFolder folder;
  VideoSettings settings;
  settings.program = "no-such-encoder";
  EXPECT_FALSE(has_video_program(settings.program));
  const Status made = encode_video({folder.path() / "a.png"}, folder.path() / "film.mp4", settings);
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().code, ErrorCode::unavailable);
  EXPECT_NE(made.error().message.find("apt-get install ffmpeg"), std::string::npos) << made.error().message;
}

TEST(Video, PassesOnTheLastWordsOfAFailure) {
  TemporaryFolder folder;
  spoil(folder.path() / "a.png", std::string(100'000, 'x'));
  const std::filesystem::path film = folder.path() / "film.mp4";
  spoil(film, "an older film");
  const Status made = encode_video({folder.path() / "a.png"}, film, {});
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().code, ErrorCode::io);
  EXPECT_NE(made.error().message.find("png"), std::string::npos) << made.error().message;
  EXPECT_EQ(contents(film), "an older film");
  EXPECT_FALSE(std::filesystem::exists(aside_of(film)));
}

TEST(Video, GivesUpOnAProgramThatTakesNothing) {
  TemporaryFolder folder;
  const std::filesystem::path program = folder.path() / "sleeper";
  spoil(program, "#!/bin/sh\nexec sleep 60\n");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  spoil(folder.path() / "a.png", std::string(4'000'000, 'x'));
  VideoSettings settings;
  settings.program = program.string();
  settings.patience = std::chrono::seconds(1);
  const Status made = encode_video({folder.path() / "a.png"}, folder.path() / "film.mp4", settings);
  ASSERT_FALSE(made.ok());
  EXPECT_NE(made.error().message.find("took no picture for 1 s"), std::string::npos) << made.error().message;
}

TEST(Video, NamesAMissingPicture) {
  TemporaryFolder folder;
  const Status made = encode_video({folder.path() / "gone.png"}, folder.path() / "film.mp4", {});
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().code, ErrorCode::missing_input);
  EXPECT_NE(made.error().message.find("gone.png"), std::string::npos) << made.error().message;
  EXPECT_EQ(encode_video({}, folder.path() / "film.mp4", {}).error().code, ErrorCode::missing_input);
}

} // namespace wry::pipeline
