#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "pipeline/report/heat_map.h"
#include "pipeline/report/plot.h"
#include "render/png.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {
namespace {

using testing::TemporaryFolder;

Plot convergence() {
  Plot plot{"Error & time", "time step [s]", "tip error [m]", PlotScale::logarithmic, PlotScale::logarithmic, {}};
  PlotSeries measured{"backward-euler", {}, {}, PlotMark::line_and_points, {}};
  PlotSeries second{"second order", {}, {}, PlotMark::dashed, {}};
  for (int i = 0; i < 6; ++i) {
    const double dt = 0.04 / (1 << i);
    measured.x.push_back(dt);
    measured.y.push_back(0.7 * dt);
    second.x.push_back(dt);
    second.y.push_back(20.0 * dt * dt);
  }
  plot.series = {measured, second};
  return plot;
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

/// x coordinates of the points of the n-th polyline with more than three points.
std::vector<std::pair<double, double>> curve(const std::string& svg, int which) {
  std::size_t at = 0;
  while ((at = svg.find("points=\"", at)) != std::string::npos) {
    at += 8;
    std::vector<std::pair<double, double>> points;
    const char* text = svg.c_str() + at;
    double x = 0.0, y = 0.0;
    int used = 0;
    while (std::sscanf(text, " %lf,%lf%n", &x, &y, &used) == 2) {
      points.emplace_back(x, y);
      text += used;
    }
    if (points.size() > 3 && which-- == 0)
      return points;
  }
  return {};
}

TEST(Plot, PowerLawsAreStraightOnLogarithmicAxes) {
  const std::string svg = plot_svg(convergence());
  const auto first = curve(svg, 0), second = curve(svg, 1);
  ASSERT_EQ(first.size(), 6u);
  ASSERT_EQ(second.size(), 6u);
  const auto slope = [](const auto& points, std::size_t i) {
    return (points[i + 1].second - points[i].second) / (points[i + 1].first - points[i].first);
  };
  for (std::size_t i = 0; i + 1 < 6; ++i) {
    EXPECT_NEAR(slope(first, i), slope(first, 0), 2e-3);
    EXPECT_NEAR(slope(second, i) / slope(first, i), 2.0, 5e-3) << "twice the order is twice as steep";
  }
}

TEST(Plot, TextIsEscapedAndEverySeriesIsInTheLegend) {
  Plot plot = convergence();
  plot.series[0].label = "<script>alert(1)</script>";
  const std::string svg = plot_svg(plot);
  EXPECT_EQ(svg.find("<script"), std::string::npos);
  EXPECT_NE(svg.find("&lt;script&gt;"), std::string::npos);
  EXPECT_NE(svg.find("second order"), std::string::npos);
  EXPECT_NE(svg.find("Error &amp; time"), std::string::npos);
}

TEST(Plot, ThemesDifferAndAutomaticHasBoth) {
  const Plot plot = convergence();
  EXPECT_NE(plot_svg(plot, PlotTheme::light), plot_svg(plot, PlotTheme::dark));
  EXPECT_NE(plot_svg(plot).find("prefers-color-scheme:dark"), std::string::npos);
  const render::Image light = plot_image(plot, PlotTheme::light), dark = plot_image(plot, PlotTheme::dark);
  EXPECT_GT(light.at(2, 2)[0], 240);
  EXPECT_LT(dark.at(2, 2)[0], 40);
}

TEST(Plot, ValuesThatAreNotNumbersBreakTheLine) {
  Plot plot;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  plot.series = {{"a", {0, 1, 2, 3, 4, 5, 6, 7, 8}, {1, 2, 3, 4, nan, 4, 3, 2, 1}, PlotMark::line, {}}};
  const std::string svg = plot_svg(plot);
  EXPECT_EQ(curve(svg, 0).size(), 4u);
  EXPECT_EQ(curve(svg, 1).size(), 4u);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  plot.y_scale = PlotScale::logarithmic;
  plot.series[0].y = {-1, 0, nan, -3, -4, 0, 0, 0, 0};
  EXPECT_NE(plot_svg(plot).find("nothing to show"), std::string::npos);
}

TEST(Plot, TicksAreRoundAndWithin) {
  EXPECT_EQ(axis_ticks(0.0, 1.0, PlotScale::linear, 5),
            (std::vector<double>{0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0}));
  EXPECT_EQ(axis_ticks(0.9, 1100.0, PlotScale::logarithmic, 6).size(), 4u);
  EXPECT_EQ(axis_ticks(1.0, 10.0, PlotScale::logarithmic, 6), (std::vector<double>{1, 2, 5, 10}));
  EXPECT_GE(axis_ticks(3.0, 3.3, PlotScale::logarithmic, 6).size(), 2u)
      << "within a digit the axis is as good as linear";
  EXPECT_LE(axis_ticks(1e-30, 1e30, PlotScale::logarithmic, 6).size(), 8u);
}

TEST(Plot, APictureShowsTheCurveWhereTheSvgHasIt) {
  Plot plot = convergence();
  plot.series.pop_back();
  plot.series[0].mark = PlotMark::line;
  const auto points = curve(plot_svg(plot), 0);
  const render::Image image = plot_image(plot, PlotTheme::light);
  ASSERT_EQ(points.size(), 6u);
  for (const auto& [x, y] : points) {
    const std::uint8_t* pixel = image.at(static_cast<int>(2 * x), static_cast<int>(2 * y));
    EXPECT_LT(pixel[0], 120) << "blue at " << x << ", " << y;
    EXPECT_GT(pixel[2], 120);
  }
}

TEST(Plot, DashesOfAnyLengthEnd) {
  Plot plot;
  for (int i = 1; i < 40; ++i) // ends that fall within a rounding of a dash's end, too
    plot.series.push_back({"", {0.0, 0.1 * i, 0.1 * i + 1e-9}, {0.0, 0.07 * i, 3.0}, PlotMark::dashed, {}});
  const render::Image image = plot_image(plot);
  EXPECT_EQ(image.width, 2 * plot.width);
}

TEST(Plot, IsWrittenAsSvgAndPng) {
  TemporaryFolder folder;
  const std::string path = (folder.path() / "convergence").string();
  ASSERT_TRUE(write_plot(path, convergence()).ok());
  EXPECT_TRUE(render::png_is_whole(path + ".png").ok());
  EXPECT_TRUE(std::filesystem::exists(path + ".svg"));
}

TEST(HeatMap, EveryCellHasItsColourAndText) {
  MapPlot map{"bar", {"1e2", "1e4"}, {"E", "dt"}, {}};
  map.cells = {{{MapMark::holds, "1.0x"}, {MapMark::fails, "70"}}, {{MapMark::refuses, ""}}};
  const std::string svg = map_svg(map);
  EXPECT_EQ(count_of(svg, "<rect"), 1u + 5u + 3u) << "paper, key and cells";
  EXPECT_NE(svg.find(">70<"), std::string::npos);
  TemporaryFolder folder;
  ASSERT_TRUE(write_map((folder.path() / "map").string(), map).ok());
  EXPECT_TRUE(render::png_is_whole(folder.path() / "map.png").ok());
}

} // namespace
} // namespace wry::pipeline
