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

} // namespace
} // namespace wry::cli_test
