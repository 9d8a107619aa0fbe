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

Words without_axes(const std::string& material, const std::string& modulus, const std::string& ratio,
                   const std::string& scale = "1") {
  const std::string of = "material." + material + '.';
  return {of + "youngs_modulus=" + modulus, of + "poisson_ratio=" + ratio, of + "plastic_scale=" + scale};
}

/// Matter of one scale has no axes, and so no directions to measure.
constexpr const char* ALL_BUT_ONE = "{ x = 1, y = 1, z = 1.00001 }";

Words joined(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// Matter with axes: at coarse cells and with one grain per particle.
const std::vector<ShippedShot>& shipped_shots_of_grains() {
  static const std::vector<ShippedShot> shots = {
      {"column",
       "sweep",
       {"body.column.sub_particles.per_particle=1"},
       {{{"material.sand.frame=fixed"}, "strong-runs-out", ""},
        {{"material.sand.plastic_scale.z=1"}, "strong-level-holds-along-its-fibres", ""}}},
      {"column_general",
       "sweep",
       {"body.column.sub_particles.per_particle=1"},
       {{{"material.sand.frame=fixed"}, "leans-along-y-a-quarter-round", ""},
        {{"material.sand.plastic_map=[[1,0,0],[0,1,0],[0,0,1]]"}, "level-spreads-less", ""}}},
      {"fibre_pull",
       "sweep",
       {"body.bundle.sub_particles.per_particle=1"},
       {{{"material.fibre.frame=fixed"}, "tilted-holds-longer", ""},
        {without_axes("fibre", "1e5", "0.1"), "along-tears-first", ""}}},
      {"fibre_hang",
       "sweep",
       {"body.bundle.sub_particles.per_particle=1"},
       {{{"material.fibre.frame=fixed"}, "across-holds-longest", ""},
        {without_axes("fibre", "1e5", "0.1"), "tilted-holds-longer", ""}}},
      {"slope",
       "sweep",
       {"mpm.cell_size=0.02", "body.block.sub_particles.per_particle=1"},
       {{{"material.straw.reorient.length_over_width=1"}, "grains-that-point-anywhere-align", ""},
        {{"material.straw.frame=fixed", "material.fixed_straw.frame=fixed"},
         "unless-they-only-roll-with-the-matter",
         ""},
        {joined(without_axes("straw", "5e5", "0.4", ALL_BUT_ONE),
                without_axes("fixed_straw", "5e5", "0.4", ALL_BUT_ONE)),
         "grains-along-the-slope-run-further", ""}}},
      {"grains",
       "sweep",
       {"mpm.cell_size=0.0133", "body.heap.sub_particles.per_particle=1"},
       {{{"material.cards.frame=fixed", "material.rods.frame=fixed", "material.layers.frame=fixed"},
         "tilted-rods-run-along-their-tilt",
         ""},
        {joined(joined(without_axes("cards", "5e4", "0.2"), without_axes("rods", "5e5", "0.2")),
                without_axes("layers", "1e4", "0.2")),
         "tilted-layers-stand-the-blow-higher", ""}}},
      {"dump_truck",
       "sweep",
       {"mpm.cell_size=0.014", "body.load.sub_particles.per_particle=1"},
       {{{"material.straw.frame=fixed"}, "vertical-keeps-more", ""},
        {without_axes("straw", "5e5", "0.4"), "vertical-lies-lower", ""}}},
  };
  return shots;
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

INSTANTIATE_TEST_SUITE_P(Grains, ShippedShotsLong, testing::ValuesIn(shipped_shots_of_grains()),
                         [](const testing::TestParamInfo<ShippedShot>& shot) { return shot.param.name; });

} // namespace
} // namespace wry::cli_test
