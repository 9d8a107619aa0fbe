#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

using Words = std::vector<std::string>;

/// A way to switch off what a shot shows, and an expectation that then does not hold.
struct SwitchedOff {
  Words sets;
  std::string fails;
  std::string of_case; ///< of [sweep], run by itself; empty: as the shot is run
};

/// A shipped shot, run with thumbnails against its own [expect]: as it is, and with its feature switched off.
struct ShippedShot {
  std::string name;
  std::string verb; ///< "sweep" where expectations compare cases
  Words coarser;    ///< `--set` words under which all of [expect] must still hold
  std::vector<SwitchedOff> off;
};

void PrintTo(const ShippedShot& shot, std::ostream* stream) {
  *stream << shot.name;
}

Words without_length_scale(const Words& materials) {
  Words sets;
  for (const std::string& material : materials)
    sets.push_back("material." + material + ".length_scale=0");
  return sets;
}

const std::vector<ShippedShot>& shipped_shots() {
  static const std::vector<ShippedShot> shots = {
      {"flexing_bar", "run", {}, {{{"material.rubber.length_scale=0"}, "it-swings-back", ""}}},
      {"closed_loop", "sweep", {}, {{{"fem.point_rotations=velocity"}, "a-reset-leaves-none", "reset-every-ten"}}},
      {"cantilever",
       "run",
       {},
       {{{"fem.point_rotations=rotation-vectors"}, "interpolated-velocity-is-near-the-sphere", ""},
        {{"body.bar.split=kuhn"}, "no-bow-up", ""}}},
      {"sheet", "sweep", {}, {{without_length_scale({"sheet"}), "isotropic-bends-as-a-whole", ""}}},
      {"plate", "sweep", {}, {{{"material.shell.bending=h3"}, "high-stiffness-holds-its-corner-up", ""}}},
      {"helix",
       "run",
       {},
       {{without_length_scale({"first", "second", "third", "fourth", "fifth"}), "radius-of-first", ""}}},
      {"lotus", "run", {}, {{without_length_scale({"outer", "middle", "inner"}), "inner-petals-stand", ""}}},
      // Cases set the length scale, so that the sweep's own --set takes the stiffnesses.
      {"bunny_ears",
       "sweep",
       {},
       {{{R"(material.skin.curvature={ model = "isotropic", alpha = 0, beta = 0, gamma = 0 })"},
         "curvature-keeps-the-width",
         ""}}},
      {"bunny",
       "sweep",
       {"body.bunny.resolution=0.06"},
       {{{"material.skin.length_scale=0"}, "soft-micropolar-stands", "soft-micropolar"}}},
  };
  return shots;
}

class ShippedShotsLong : public testing::TestWithParam<ShippedShot> {
protected:
  Outcome run(const Words& sets, const std::string& of_case) const {
    const TemporaryFolder folder;
    Words words = {of_case.empty() ? GetParam().verb : "run",
                   std::string(WRY_SOURCE_DIR) + "/shots/" + GetParam().name + ".toml",
                   "--out",
                   (folder.path() / "out").string(),
                   "--set",
                   "render.size=[64, 36]",
                   "--set",
                   "render.samples=1"};
    if (!of_case.empty())
      words.insert(words.end(), {"--case", of_case});
    for (const Words& more : {GetParam().coarser, sets})
      for (const std::string& set : more)
        words.insert(words.end(), {"--set", set});
    return run_wry(words, folder.path());
  }
};

TEST_P(ShippedShotsLong, HoldsWhatItExpects) {
  const Outcome outcome = run({}, "");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
}

TEST_P(ShippedShotsLong, FailsWithItsFeatureSwitchedOff) {
  for (const SwitchedOff& off : GetParam().off) {
    const Outcome outcome = run(off.sets, off.of_case);
    EXPECT_EQ(outcome.exit_code, 1) << off.sets.front() << '\n' << outcome.err;
    EXPECT_THAT(outcome.err + outcome.out, testing::HasSubstr(off.fails)) << off.sets.front();
  }
}

INSTANTIATE_TEST_SUITE_P(Shots, ShippedShotsLong, testing::ValuesIn(shipped_shots()),
                         [](const testing::TestParamInfo<ShippedShot>& shot) { return shot.param.name; });

} // namespace
} // namespace wry::cli_test
