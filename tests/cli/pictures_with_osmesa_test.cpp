#include <cstdlib>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

namespace fs = std::filesystem;

class Pictures : public testing::Test {
protected:
  Pictures() { write_text(m_folder.path() / "bar.toml", small_shot()); }
  const TemporaryFolder m_folder;
};

TEST_F(Pictures, AreDrawnOnceAndAgainWhenDamaged) {
  const std::vector<std::string> arguments = {"run", "bar.toml", "--out", "a", "--frames", "1-2"};
  const Outcome run = run_wry(arguments, m_folder.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const fs::path picture = m_folder.path() / "a" / "images" / "bar.beauty.0002.png";
  const std::string bytes = read_text(picture);
  ASSERT_GT(bytes.size(), 1000u);
  const fs::file_time_type time = fs::last_write_time(picture);
  ASSERT_EQ(run_wry(arguments, m_folder.path()).exit_code, 0);
  EXPECT_EQ(fs::last_write_time(picture), time);
  write_text(picture, bytes.substr(0, bytes.size() / 2));
  ASSERT_EQ(run_wry(arguments, m_folder.path()).exit_code, 0);
  EXPECT_EQ(read_text(picture), bytes);
}

TEST_F(Pictures, AreFollowedByExpectationsOfOneFrameOrOfEvery) {
  const auto exit_with = [&](const std::string& expectation) {
    write_text(m_folder.path() / "bar.toml", small_shot() + "[expect.low]\nmeasure = \"height\"\n" + expectation);
    return run_wry({"run", "bar.toml", "--out", "a", "--quiet"}, m_folder.path()); // simulates and draws only once
  };
  EXPECT_EQ(exit_with("max = 0.1001\nframe = 1\n").exit_code, 0); // its free end has not sunk yet
  const Outcome every = exit_with("max = 0.1001\nevery_frame = true\n");
  EXPECT_EQ(every.exit_code, 1);
  EXPECT_NE(every.err.find("height is"), std::string::npos) << every.err;
  EXPECT_NE(every.err.find("expected at most 0.1001"), std::string::npos) << every.err;
  EXPECT_EQ(exit_with("max = 0.1001\n").exit_code, 1);
  EXPECT_EQ(exit_with("min = 0.0999\nevery_frame = true\n").exit_code, 0);
  EXPECT_EQ(exit_with("min = 0.1001\nevery_frame = true\n").exit_code, 1);
  EXPECT_EQ(exit_with("min = 0.1001\nevery_frame = true\nframe = 9\n").exit_code, 0);
}

TEST_F(Pictures, OfFewerFramesAreNotHeldAgainstWhatIsExpectedOfOthers) {
  write_text(m_folder.path() / "bar.toml", small_shot() +
                                               "[expect.low]\nmeasure = \"height\"\nmax = 0\n"
                                               "[expect.sinks]\nmeasure = \"height\"\nmax = 0\nframe = 5\n"
                                               "[expect.starts]\nmeasure = \"height\"\nmin = 0.09\nframe = 1\n");
  const Outcome few = run_wry({"run", "bar.toml", "--out", "few", "--frames", "1-2"}, m_folder.path());
  EXPECT_EQ(few.exit_code, 0) << few.err;
  EXPECT_NE(few.out.find("1 expectations hold"), std::string::npos) << few.out;
  EXPECT_NE(few.out.find("not judged: low (frame 9 was not asked for)"), std::string::npos) << few.out;
  EXPECT_NE(few.out.find("not judged: sinks (frame 5 was not asked for)"), std::string::npos) << few.out;
  const std::string summary = read_text(m_folder.path() / "few/summary.json");
  EXPECT_NE(summary.find("\"sinks\": \"not judged: frame 5"), std::string::npos) << summary;
}

TEST_F(Pictures, OfAFrameThatIsNotThereCannotBeDrawn) {
  ASSERT_EQ(run_wry({"simulate", "bar.toml", "--out", "a", "--frames", "1-2"}, m_folder.path()).exit_code, 0);
  const Outcome drawn =
      run_wry({"render", "bar.toml", "--out", "a", "--frames", "5", "--threads", "1"}, m_folder.path());
  EXPECT_EQ(drawn.exit_code, 66) << drawn.err;
  EXPECT_NE(drawn.err.find("frame 5"), std::string::npos) << drawn.err;
}

TEST_F(Pictures, OfATurntableDoNotRepeatTheFirst) {
  ASSERT_EQ(run_wry({"simulate", "bar.toml", "--out", "a", "--frames", "1-2"}, m_folder.path()).exit_code, 0);
  const Outcome turned = run_wry(
      {"turntable", "bar.toml", "--out", "a", "--set", "render.turntable.frames=6", "--frame", "2"}, m_folder.path());
  ASSERT_EQ(turned.exit_code, 0) << turned.err;
  const fs::path folder = m_folder.path() / "a" / "turntable";
  EXPECT_TRUE(fs::exists(folder / "bar.0002.0006.png"));
  EXPECT_FALSE(fs::exists(folder / "bar.0002.0007.png"));
  EXPECT_NE(read_text(folder / "bar.0002.0001.png"), read_text(folder / "bar.0002.0006.png"));
}

TEST_F(Pictures, DoneTheErrorIsTheLastWordInTheLogOfAFarm) {
  write_text(m_folder.path() / "bar.toml", small_shot() + R"(
[expect.low]
measure = "height"
frame = 2
max = -1e3
)");
  const std::string command =
      "cd " + m_folder.path().string() + " && " + WRY_PROGRAM + " run bar.toml --frames 1-2 --out a > log 2>&1";
  EXPECT_NE(std::system(command.c_str()), 0);
  const std::string log = read_text(m_folder.path() / "log");
  const std::size_t error = log.rfind("\nwry run: ");
  ASSERT_NE(error, std::string::npos) << log;
  EXPECT_EQ(log.find("pictures", error), std::string::npos) << log;
  EXPECT_NE(log.find("expect.low", error), std::string::npos) << log;
}

TEST_F(Pictures, OfABareMeshDoNotLeaveAnOptionUnheard) {
  write_text(m_folder.path() / "one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  for (const auto& [option, value] : {std::pair("--set", "render.turntable.frames=4"), std::pair("--frames", "1-4")}) {
    const Outcome turned = run_wry({"turntable", "one.obj", option, value}, m_folder.path());
    EXPECT_EQ(turned.exit_code, 2) << turned.err;
    EXPECT_NE(turned.err.find(option), std::string::npos) << turned.err;
  }
}

TEST_F(Pictures, ComeWithLayersASheetAndClearBackgroundsWhenAsked) {
  const Outcome run = run_wry({"run", "bar.toml", "--out", "a", "--frames", "1-3", "--set",
                               "render.exr=[\"colour\",\"Z\",\"N\",\"velocity\",\"id\"]", "--set",
                               "render.contact_sheet=true", "--set", "render.bits=\"16\"", "--set",
                               "render.ground.catch_shadow=true", "--set", "render.camera.orbit_turns=0.25"},
                              m_folder.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const fs::path images = m_folder.path() / "a" / "images";
  EXPECT_GT(read_text(images / "bar.beauty.0003.exr").size(), 1000u);
  EXPECT_GT(read_text(images / "bar.beauty.sheet.png").size(), 1000u);
  const std::string png = read_text(images / "bar.beauty.0002.png");
  EXPECT_EQ(png[24], 16); // bits a channel
  EXPECT_EQ(png[25], 6);  // with alpha
}

TEST_F(Pictures, AreDrawnBesideARunningSimulationEachOnce) {
  ASSERT_EQ(run_wry({"simulate", "bar.toml", "--out", "a", "--frames", "1-2"}, m_folder.path()).exit_code, 0);
  const Outcome followed =
      run_wry({"render", "bar.toml", "--out", "a", "--frames", "1-2", "--follow"}, m_folder.path());
  ASSERT_EQ(followed.exit_code, 0) << followed.err;
  EXPECT_TRUE(fs::exists(m_folder.path() / "a" / "images" / "bar.beauty.0002.png"));
}

TEST_F(Pictures, OfTwoRunsAreSplitAndSubtracted) {
  ASSERT_EQ(run_wry({"run", "bar.toml", "--out", "a", "--frames", "1-2"}, m_folder.path()).exit_code, 0);
  const std::vector<std::string> compare = {"compare", "a", "--with", "a", "--mode", "difference", "--out", "d"};
  const Outcome same = run_wry(compare, m_folder.path());
  ASSERT_EQ(same.exit_code, 0) << same.err;
  EXPECT_NE(same.out.find("0 of 2 pictures differ"), std::string::npos) << same.out;
  EXPECT_TRUE(fs::exists(m_folder.path() / "d" / "difference.beauty.0001.png"));
  EXPECT_EQ(run_wry({"compare", "a", "--with", "nowhere"}, m_folder.path()).exit_code, 66);
  EXPECT_EQ(run_wry({"compare", "a"}, m_folder.path()).exit_code, 2);
}

TEST_F(Pictures, BadInputEndsWithItsOwnCode) {
  ASSERT_EQ(run_wry({"simulate", "bar.toml", "--out", "a", "--frames", "1"}, m_folder.path()).exit_code, 0);
  const auto drawn = [&](const std::string& set) {
    return run_wry({"render", "bar.toml", "--out", "a", "--frames", "1", "--threads", "1", "--set", set},
                   m_folder.path());
  };
  EXPECT_EQ(drawn("render.size=[20000,100]").exit_code, 65);
  EXPECT_EQ(drawn("render.lights={rig=\"image\"}").exit_code, 65);
  const Outcome missing = drawn("render.lights={rig=\"image\",image=\"nowhere.hdr\"}");
  EXPECT_EQ(missing.exit_code, 66) << missing.err;
  EXPECT_NE(missing.err.find("nowhere.hdr"), std::string::npos);
  const Outcome channel = drawn("render.views=[\"heat.nothing\"]");
  EXPECT_EQ(channel.exit_code, 65) << channel.err;
  EXPECT_NE(channel.err.find("nothing"), std::string::npos);
  EXPECT_EQ(drawn("render.camera.keys=[{frame=5,position=[3,3,3]},{frame=2,position=[1,3,3]}]").exit_code, 65);
}

} // namespace
} // namespace wry::cli_test
