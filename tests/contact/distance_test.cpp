#include "sim/contact/distance.h"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace wry::contact {
namespace {

PairPoints points_of(std::initializer_list<double> values) {
  PairPoints points;
  int i = 0;
  for (const double value : values) {
    points(i / 3, i % 3) = value;
    ++i;
  }
  return points;
}

struct Case {
  const char* name;
  PairKind kind;
  int parameters;
  double distance;
  PairPoints points;
};

std::vector<Case> cases() {
  constexpr PairKind PT = PairKind::point_triangle;
  constexpr PairKind EE = PairKind::edge_edge;
  return {
      {"face", PT, 2, 0.5, points_of({0.2, 0.5, 0.3, 0, 0, 0, 1, 0, 0, 0, 0, 1})},
      {"face from below", PT, 2, 0.1, points_of({0.2, -0.1, 0.3, 0, 0, 0, 1, 0, 0, 0, 0, 1})},
      {"edge of a triangle", PT, 1, 0.5, points_of({0.4, 0.3, -0.4, 0, 0, 0, 1, 0, 0, 0, 0, 1})},
      {"long side of a triangle", PT, 1, std::sqrt(0.5 + 0.04), points_of({1.0, 0.2, 1.0, 0, 0, 0, 1, 0, 0, 0, 0, 1})},
      {"corner of a triangle", PT, 0, 0.6, points_of({-0.4, 0.4, -0.2, 0, 0, 0, 1, 0, 0, 0, 0, 1})},
      {"crossing", EE, 2, 0.3, points_of({-1, 0.3, 0.1, 2, 0.3, 0.2, 0.2, 0, -1, 0.4, 0, 1})},
      {"end against an edge", EE, 1, std::sqrt(0.09 + 0.25),
       points_of({1.5, 0.3, 0.2, 3, 0.3, 0.5, 1, 0, -1, 1, 0, 1})},
      {"edge against an end", EE, 1, std::sqrt(0.09 + 0.25),
       points_of({1, 0, -1, 1, 0, 1, 1.5, 0.3, 0.2, 3, 0.3, 0.5})},
      {"end against an end", EE, 0, std::sqrt(0.3), points_of({0, 0, 0, -1, -0.1, -0.2, 0.1, 0.2, 0.5, 1, 2, 3})},
  };
}

TEST(Distance, IsThatOfTheNearestFeatures) {
  for (const Case& c : cases()) {
    const PairDistance pair = pair_distance(c.kind, c.points);
    EXPECT_EQ(pair.parameters, c.parameters) << c.name;
    EXPECT_NEAR(pair.distance, c.distance, 1e-14) << c.name;
    EXPECT_NEAR(squared_distance(c.kind, c.points), c.distance * c.distance, 1e-14) << c.name;
    EXPECT_NEAR((separating_direction(c.kind, c.points) - pair.normal).norm(), 0.0, 1e-12) << c.name;
    EXPECT_NEAR(pair.weights.sum(), 0.0, 1e-15) << c.name;
    EXPECT_NEAR((c.points.transpose() * pair.weights - pair.distance * pair.normal).norm(), 0.0, 1e-14) << c.name;
  }
}

TEST(Distance, AgreesWithABruteForceSearch) {
  std::srand(7);
  for (int trial = 0; trial < 200; ++trial) {
    const PairPoints points = PairPoints::Random();
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
      constexpr int STEPS = 120;
      double best = 1e9;
      for (int i = 0; i <= STEPS; ++i) {
        for (int j = 0; j <= (kind == PairKind::edge_edge ? STEPS : STEPS - i); ++j) {
          const double s = double(i) / STEPS;
          const double t = double(j) / STEPS;
          const Vec4 w = kind == PairKind::edge_edge ? Vec4(1 - s, s, t - 1, -t) : Vec4(1, s + t - 1, -s, -t);
          best = std::min(best, (points.transpose() * w).norm());
        }
      }
      const double distance = pair_distance(kind, points).distance;
      EXPECT_LE(distance, best + 1e-12);
      EXPECT_GT(distance, best - 0.03);
      EXPECT_NEAR(squared_distance(kind, points), distance * distance, 1e-12);
      EXPECT_NEAR((separating_direction(kind, points) - pair_distance(kind, points).normal).norm(), 0.0, 1e-8);
    }
  }
}

template <class Function> void expect_derivatives(const Case& c, const Function& function) {
  constexpr double STEP = 1e-6;
  const auto [value, gradient, hessian] = function(c.points);
  const double scale = std::max(1.0, hessian.cwiseAbs().maxCoeff());
  EXPECT_NEAR((hessian - hessian.transpose()).norm(), 0.0, 1e-12 * scale) << c.name;
  for (int i = 0; i < 12; ++i) {
    PairPoints above = c.points;
    PairPoints below = c.points;
    above(i / 3, i % 3) += STEP;
    below(i / 3, i % 3) -= STEP;
    const auto [value_above, gradient_above, h1] = function(above);
    const auto [value_below, gradient_below, h2] = function(below);
    EXPECT_NEAR(gradient[i], (value_above - value_below) / (2 * STEP), 1e-8 * scale) << c.name << " " << i;
    const Gradient column = (gradient_above - gradient_below) / (2 * STEP);
    EXPECT_NEAR((hessian.col(i) - column).norm(), 0.0, 1e-7 * scale) << c.name << " " << i;
  }
}

struct Jet {
  double value;
  Gradient gradient;
  Hessian hessian;
};

TEST(Distance, HasDerivativesThatDifferencesConfirm) {
  for (const Case& c : cases()) {
    expect_derivatives(c, [&](const PairPoints& points) {
      const PairDistance pair = pair_distance(c.kind, points);
      return Jet{pair.distance, distance_gradient(pair), distance_hessian(pair)};
    });
  }
}

TEST(Mollifier, HasDerivativesThatDifferencesConfirm) {
  for (const Case& c : cases()) {
    expect_derivatives(c, [&](const PairPoints& points) {
      return Jet{cross_squared(points), cross_squared_gradient(points), cross_squared_hessian(points)};
    });
  }
  const Mollifier middle = evaluate_mollifier(0.3, 0.5);
  const double step = 1e-6;
  const Mollifier above = evaluate_mollifier(0.3 + step, 0.5);
  const Mollifier below = evaluate_mollifier(0.3 - step, 0.5);
  EXPECT_NEAR(middle.slope, (above.value - below.value) / (2 * step), 1e-9);
  EXPECT_NEAR(middle.second, (above.slope - below.slope) / (2 * step), 1e-8);
}

TEST(Mollifier, GoesSmoothlyFromZeroForParallelEdgesToOne) {
  EXPECT_EQ(evaluate_mollifier(0.0, 0.5).value, 0.0);
  EXPECT_EQ(evaluate_mollifier(0.5, 0.5).value, 1.0);
  EXPECT_NEAR(evaluate_mollifier(0.5 - 1e-9, 0.5).value, 1.0, 1e-12);
  EXPECT_NEAR(evaluate_mollifier(0.5 - 1e-9, 0.5).slope, 0.0, 1e-7);
}

TEST(Distance, TinyGapsKeepTheirDigits) {
  // A face 1e-12 under a point: the normal stays that of the face.
  const PairPoints points = points_of({0.3, 1e-12, 0.3, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  const PairDistance pair = point_triangle_distance(points);
  EXPECT_NEAR(pair.distance, 1e-12, 1e-24);
  EXPECT_NEAR(pair.normal.y(), 1.0, 1e-15);
}

} // namespace
} // namespace wry::contact
