#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

#include "pipeline/report/csv_table.h"
#include "tests/cli/browser_support.h"
#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

namespace fs = std::filesystem;

/// Screenshots are kept where WRY_SCREENSHOTS says.
void keep_screenshot(Browser& browser, const std::string& name) {
  if (const char* folder = std::getenv("WRY_SCREENSHOTS"); folder != nullptr)
    browser.save_screenshot(fs::path(folder) / name);
}

struct Box {
  double x, y, width, height;
};
Box box_of(Browser& browser, const std::string& selector) {
  const nlohmann::json rect =
      browser.evaluate("(() => { const r = document.querySelector('" + selector +
                       "').getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; })()");
  return {rect.at(0), rect.at(1), rect.at(2), rect.at(3)};
}

TEST(SweepPage, IsScrubbedSlidAndFilteredInABrowserWithoutAServer) {
  if (!Browser::is_installed())
    GTEST_SKIP() << "needs chromium";
  const TemporaryFolder folder;
  write_text(folder.path() / "bar.toml", small_shot() + R"([sweep]
"material.soft.youngs_modulus" = [5e3, 2e4, 8e4]
"material.soft.poisson_ratio" = [0.1, 0.3, 0.7]
)");
  ASSERT_EQ(run_wry({"sweep", "bar.toml", "--out", "s"}, folder.path()).exit_code, 1) << "0.7 is no Poisson's ratio";
  Browser browser(1280, 900);
  ASSERT_EQ(browser.problem(), "");
  browser.open(folder.path() / "s" / "index.html");
  EXPECT_EQ(browser.evaluate("document.querySelectorAll('.wedge').length"), 9);
  EXPECT_EQ(browser.evaluate("document.querySelectorAll('#ftable tr').length"), 3) << "failures are listed";
  EXPECT_NE(browser.evaluate("document.getElementById('ftable').textContent").get<std::string>().find("poisson_ratio"),
            std::string::npos);
  keep_screenshot(browser, "sweep-page.png");

  // Scrubbing moves every wedge to the same frame at once.
  const Box scrub = box_of(browser, "#scrub");
  browser.drag(scrub.x + scrub.width - 8, scrub.y + scrub.height / 2, scrub.x + scrub.width / 2,
               scrub.y + scrub.height / 2);
  const nlohmann::json frames = browser.evaluate(
      "[...new Set([...document.querySelectorAll('.wedge .picture[data-frame]')].map(b => b.dataset.frame))]");
  ASSERT_EQ(frames.size(), 1u) << frames.dump();
  EXPECT_EQ(frames[0], "5") << "the middle of frames 1 to 9";
  EXPECT_EQ(browser.evaluate("document.getElementById('frame').textContent"), "frame 5");

  // A slider takes the focus to the wedge with that value and the same others.
  const std::string before = browser.evaluate("document.querySelector('.wedge.chosen').dataset.id");
  const Box slider = box_of(browser, "#sliders input");
  browser.click(slider.x + slider.width - 3, slider.y + slider.height / 2);
  const std::string after = browser.evaluate("document.querySelector('.wedge.chosen').dataset.id");
  EXPECT_NE(after, before);
  EXPECT_EQ(browser.evaluate("document.querySelector('#sliders .slider span:last-child').textContent"), "80000");

  // Filtering by a measure leaves fewer.
  browser.evaluate("(() => { const m = document.getElementById('fmeasure'); m.value = 'height'; m.oninput(); "
                   "const f = document.getElementById('fmin'); f.value = 1e9; f.oninput(); })()");
  EXPECT_EQ(browser.evaluate("document.querySelectorAll('.wedge').length"), 0);
  browser.evaluate("(() => { const f = document.getElementById('fmin'); f.value = ''; f.oninput(); })()");
  EXPECT_EQ(browser.evaluate("document.querySelectorAll('.wedge').length"), 6) << "wedges without the measure are out";
  EXPECT_GE(browser.evaluate("document.querySelectorAll('#overparam circle').length").get<int>(), 6);
  keep_screenshot(browser, "sweep-page-after.png");
  EXPECT_EQ(browser.complaints(), "");
}

TEST(RunReport, FitsAPhoneAndAWideScreen) {
  if (!Browser::is_installed())
    GTEST_SKIP() << "needs chromium";
  const TemporaryFolder folder;
  write_text(folder.path() / "bar.toml", small_shot());
  ASSERT_EQ(run_wry({"run", "bar.toml", "--out", "o"}, folder.path()).exit_code, 0);
  for (const int width : {1280, 390}) {
    Browser browser(width, 900);
    ASSERT_EQ(browser.problem(), "");
    browser.open(folder.path() / "o" / "report.html");
    EXPECT_LE(browser.evaluate("document.documentElement.scrollWidth").get<int>(), width) << "nothing sticks out";
    EXPECT_GE(browser.evaluate("document.querySelectorAll('svg.plot').length").get<int>(), 4);
    EXPECT_TRUE(browser.evaluate("[...document.images].every(i => i.complete && i.naturalWidth > 0)").get<bool>());
    keep_screenshot(browser, "report-" + std::to_string(width) + ".png");
    EXPECT_EQ(browser.complaints(), "");
  }
}

} // namespace
} // namespace wry::cli_test
