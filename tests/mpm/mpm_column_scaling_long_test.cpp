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

// Lube et al. 2004: 1.24 a below 1.7, 1.6 sqrt(a) above. Lajeunesse et al. 2004: a below 3, a^1/2 above.
TEST(ColumnScaling, RunsOutInProportionToLowAspectsAndToTheRootOfHighOnes) {
  const std::vector<double> aspects = {0.5, 1.0, 2.0, 4.0, 7.0, 10.0};
  std::vector<RunOut> spread;
  for (const double aspect : aspects) {
    spread.push_back(run_out({.aspect = aspect}));
    const double lube = aspect < 1.7 ? 1.24 * aspect : 1.6 * std::sqrt(aspect);
    std::printf("a = %4.1f  front %.3f  98 %% of the mass %.3f  Lube et al. %.3f\n", aspect, spread.back().front,
                spread.back().most_mass, lube);
    std::fflush(stdout);
  }
  const double low = exponent(aspects, spread, 0.5, 2.0);
  const double high = exponent(aspects, spread, 4.0, 10.0);
  std::printf("exponents of the front: %.2f from .5 to 2, %.2f from 4 to 10\n", low, high);
  EXPECT_NEAR(low, 1.0, 0.25);
  EXPECT_NEAR(high, 0.5, 0.15);
}

} // namespace
} // namespace wry::mpm::test
