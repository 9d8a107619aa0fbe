#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/measure/measure.h"
#include "render/look.h"
#include "shots/reference.h"
#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

TEST(Reference, TheShotFilesPageIsWhatTheBuildSays) {
  EXPECT_EQ(read_text(std::string(WRY_SOURCE_DIR) + "/docs/shot-file.md"), shots::reference_markdown())
      << "make it again: wry schema --markdown > docs/shot-file.md";
}

TEST(Reference, LooksThatAShotMayNameAreThoseOfTheRenderer) {
  std::vector<std::string> named = shots::list_built_in_looks();
  std::vector<std::string> there;
  for (const auto& [name, look] : render::built_in_looks())
    there.push_back(name);
  std::sort(named.begin(), named.end());
  EXPECT_EQ(named, there);
}

TEST(Reference, EveryMeasureThatAShotMayAskForCanBeEvaluated) {
  std::vector<std::string> asked = shots::list_choices("measure.*.kind");
  std::vector<std::string> there;
  for (const pipeline::MeasureFunction& function : pipeline::measure_functions())
    there.emplace_back(function.name);
  std::sort(asked.begin(), asked.end());
  std::sort(there.begin(), there.end());
  EXPECT_EQ(asked, there);
}

} // namespace
} // namespace wry::cli_test
