#include <cmath>
#include <cstdio>
#include <vector>

#include <gtest/gtest.h>

#include "tests/mpm/column_collapse_support.h"

namespace wry::mpm::test {
namespace {

/// The slope of the line through these points on doubly logarithmic paper.
double exponent(const std::vector<double>& aspects, const std::vector<RunOut>& spread, double low, double high) {
  double n = 0.0, sum_x = 0.0, sum_y = 0.0, sum_xx = 0.0, sum_xy = 0.0;
  for (std::size_t i = 0; i < aspects.size(); ++i) {
    if (aspects[i] < low || aspects[i] > high)
      continue;
    const double x = std::log(aspects[i]), y = std::log(spread[i].front);
    n += 1.0;
    sum_x += x;
    sum_y += y;
    sum_xx += x * x;
    sum_xy += x * y;
  }
  return (n * sum_xy - sum_x * sum_y) / (n * sum_xx - sum_x * sum_x);
}

double exponent_between(double a, double b, const RunOut& at_a, const RunOut& at_b) {
  return std::log(at_b.front / at_a.front) / std::log(b / a);
}

// Lube et al. 2004: 1.24 a below 1.7, 1.6 sqrt(a) above. Lajeunesse et al. 2004: a below 3, a^1/2 above. Here the root
// is not reached at once: from 2 on the exponent falls with the aspect, to that of the root between 7 and 10.
TEST(ColumnScaling, RunsOutInProportionToLowAspectsAndComesToTheRootOfHighOnes) {
  const std::vector<double> aspects = {0.5, 1.0, 2.0, 4.0, 7.0, 10.0};
  std::vector<RunOut> spread;
  for (const double aspect : aspects) {
    spread.push_back(run_out({.aspect = aspect}));
    const double lube = aspect < 1.7 ? 1.24 * aspect : 1.6 * std::sqrt(aspect);
    std::printf("a = %4.1f  front %.3f  98 %% of the mass %.3f  Lube et al. %.3f\n", aspect, spread.back().front,
                spread.back().most_mass, lube);
    std::fflush(stdout);
    EXPECT_GT(spread.back().front, 0.6 * lube) << aspect;
    EXPECT_LT(spread.back().front, 1.1 * lube) << aspect;
  }
  EXPECT_NEAR(exponent(aspects, spread, 0.5, 2.0), 1.0, 0.25);
  const double from_2 = exponent_between(2.0, 4.0, spread[2], spread[3]);
  const double from_4 = exponent_between(4.0, 7.0, spread[3], spread[4]);
  const double from_7 = exponent_between(7.0, 10.0, spread[4], spread[5]);
  std::printf("exponents of the front: %.2f from 2 to 4, %.2f from 4 to 7, %.2f from 7 to 10\n", from_2, from_4,
              from_7);
  EXPECT_LT(from_2, 0.9);
  EXPECT_LT(from_4, from_2 - 0.05);
  EXPECT_LT(from_7, from_4 - 0.05);
  EXPECT_NEAR(from_7, 0.5, 0.15);
}

} // namespace
} // namespace wry::mpm::test
