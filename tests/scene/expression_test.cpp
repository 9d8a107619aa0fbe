#include "sim/scene/expression.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "sim/geometry/structured_tets.h"

namespace wry::scene {
namespace {

double value_of(const std::string& text, const ExpressionPoint& point = {}) {
  const Result<Expression> expression = Expression::compile(text);
  EXPECT_TRUE(expression) << (expression ? "" : expression.error().message);
  if (!expression)
    return std::numeric_limits<double>::quiet_NaN();
  const Result<double> value = expression->evaluate(point);
  EXPECT_TRUE(value) << (value ? "" : value.error().message);
  return value ? *value : std::numeric_limits<double>::quiet_NaN();
}

std::string error_of(const std::string& text, const std::vector<std::string>& attributes = {}) {
  const Result<Expression> expression = Expression::compile(text, attributes);
  EXPECT_FALSE(expression) << text;
  if (expression)
    return "";
  EXPECT_EQ(expression.error().code, ErrorCode::bad_input);
  return expression.error().message;
}

TEST(Expression, SeesTimePositionAndBodyCoordinates) {
  ExpressionPoint point;
  point.time = 2;
  point.position = {3, 5, 7};
  point.u = 0.25;
  point.v = 0.75;
  EXPECT_EQ(value_of("t + 10*X + 100*Y + 1000*Z", point), 2 + 30 + 500 + 7000);
  EXPECT_EQ(value_of("u - v", point), -0.5);
  EXPECT_EQ(value_of("8*smoothstep(0, 2, t)", point), 8);
  EXPECT_EQ(value_of("Y < 0.02", point), 0);
  EXPECT_EQ(value_of("Y >= 5 && Z != 1 || X == 0", point), 1);
  EXPECT_EQ(value_of("X > 2 ? 4 : 6", point), 4);
}

TEST(Expression, FunctionsMeetTheirDefinitions) {
  EXPECT_EQ(value_of("pi"), std::numbers::pi);
  EXPECT_EQ(value_of("smoothstep(1, 3, 0)"), 0);
  EXPECT_EQ(value_of("smoothstep(1, 3, 1.5)"), 0.25 * 0.25 * (3 - 0.5));
  EXPECT_EQ(value_of("smoothstep(1, 3, 9)"), 1);
  EXPECT_EQ(value_of("smoothstep(3, 1, 1.5)"), 0.75 * 0.75 * (3 - 1.5)); // falls when a > b
  EXPECT_EQ(value_of("smoothstep(1, 1, 1)"), 1);
  EXPECT_EQ(value_of("smoothstep(1, 1, 0.9)"), 0);
  EXPECT_EQ(value_of("lerp(2, 6, 0.25)"), 3);
  EXPECT_EQ(value_of("lerp(2, 6, 2)"), 10);
  EXPECT_EQ(value_of("clamp(7, 0, 1) + clamp(-7, 0, 1) + clamp(0.5, 0, 1)"), 1.5);
  EXPECT_EQ(value_of("min(3, 1, 2) + max(3, 1, 2)"), 4);
  EXPECT_EQ(value_of("floor(-1.5) + ceil(-1.5)"), -3);
  EXPECT_EQ(value_of("-2^2"), -4);
  EXPECT_EQ(value_of("2^3^2"), 512);
  EXPECT_NEAR(value_of("sin(pi/6) + atan2(1, 1) + exp(ln(2)) + log10(100)"), 0.5 + std::numbers::pi / 4 + 2 + 2, 1e-14);
  EXPECT_EQ(value_of("1e-3*1E3"), 1);
}

TEST(Expression, UnknownNamesNameColumnAndNearestKnown) {
  EXPECT_NE(error_of("8*smothstep(0, 2, t)").find("column 3: unknown function 'smothstep'; did you mean 'smoothstep'?"),
            std::string::npos);
  EXPECT_NE(error_of("1 + x").find("column 5: unknown name 'x'; did you mean 'X'?"), std::string::npos);
  EXPECT_NE(error_of("wetnes > 0", {"wetness"}).find("did you mean 'wetness'?"), std::string::npos);
  EXPECT_NE(error_of("banana").find("known are t, X, Y, Z, u, v, pi"), std::string::npos);
  EXPECT_NE(error_of("sin + 1").find("needs parentheses"), std::string::npos);
  EXPECT_NE(error_of("X(2)").find("no function"), std::string::npos);
}

TEST(Expression, RefusesAssignmentsStringsUnitsAndSeveralValues) {
  EXPECT_NE(error_of("t = 3").find("column 3: formulas cannot assign"), std::string::npos);
  EXPECT_NE(error_of("\"a\"").find("no strings"), std::string::npos);
  EXPECT_NE(error_of("3m").find("units"), std::string::npos);
  EXPECT_NE(error_of("1,5").find("2 values"), std::string::npos);
  EXPECT_NE(error_of("1e999").find("out of range"), std::string::npos);
  for (const char* text :
       {"",     "  ",  "(",      "1 +",  "sin(", "min()", "lerp(1, 2)", "2 3",   "t++", "a.b", "X; Y",     "1..2",
        "0x10", "_pi", "X += 1", "\x01", "\xff", "t)",    ")(",         "1 ? 2", ": 3", "&&",  "sin(1,2)", "@"})
    error_of(text);
  error_of(std::string(5000, '1'));
}

TEST(Expression, DeepNestingAndNoiseNeverCrash) {
  std::string nested;
  for (int i = 0; i < 2000; ++i)
    nested += "(";
  nested += "1";
  for (int i = 0; i < 2000; ++i)
    nested += ")";
  EXPECT_EQ(value_of(nested), 1);
  std::mt19937 random(5);
  const std::vector<std::string> pieces = {"t", "X",  "u", "pi",   "(",     ")",    "+", "-", "*",  "/",
                                           "^", ",",  "?", ":",    "1",     "2.",   "<", "=", "==", "!",
                                           "&", "&&", "|", "sin(", "lerp(", "max(", "e", " ", "."};
  int compiled = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    const std::size_t length = random() % 12 + 1;
    for (std::size_t k = 0; k < length; ++k)
      text += pieces[random() % pieces.size()];
    const Result<Expression> expression = Expression::compile(text);
    if (!expression)
      continue;
    ++compiled;
    const Result<double> value = expression->evaluate({});
    EXPECT_TRUE(!value || std::isfinite(*value));
  }
  EXPECT_GT(compiled, 100);
}

TEST(Expression, ValuesThatAreNotFiniteAreErrorsThatNameThePlace) {
  const Result<Expression> root = Expression::compile("sqrt(X - 1)");
  ASSERT_TRUE(root);
  EXPECT_FALSE(root->evaluate({}));
  EXPECT_NE(root->evaluate({}).error().message.find("X = 0"), std::string::npos);
  ExpressionPoint point;
  point.position = {5, 0, 0};
  EXPECT_EQ(*root->evaluate(point), 2);
  EXPECT_FALSE(Expression::compile("1/Y")->evaluate({}));
}

TEST(Expression, KnowsWhatItUses) {
  const Result<Expression> expression = Expression::compile("8*smoothstep(0, 2, t) + u*0");
  EXPECT_TRUE(expression->uses("t"));
  EXPECT_TRUE(expression->uses("u"));
  EXPECT_FALSE(expression->uses("X"));
  EXPECT_FALSE(expression->is_constant());
  EXPECT_TRUE(Expression::compile("2*pi")->is_constant());
}

RestPoints rod_points() {
  return rest_points(geometry::make_block_tets(geometry::rod_block(2, 0.1, 0.1, geometry::Section::box), 0.02).value());
}

TEST(Expression, AllPointsAgreeWithSinglePointsOnAnyNumberOfThreads) {
  RestPoints points = rod_points();
  geometry::VertexAttribute heat{"heat", 1, {}};
  geometry::VertexAttribute colour{"colour", 3, {}};
  for (Eigen::Index i = 0; i < points.positions.rows(); ++i) {
    heat.values.push_back(0.5 * static_cast<double>(i));
    colour.values.insert(colour.values.end(), {1.0, 2.0, static_cast<double>(i)});
  }
  points.attributes = {heat, colour};
  const std::vector<std::string> names = component_names(points.attributes);
  EXPECT_EQ(names, (std::vector<std::string>{"heat", "colour_x", "colour_y", "colour_z"}));
  const Result<Expression> expression = Expression::compile("sin(3*X)*exp(Y) + t*u + v + heat + 7*colour_z", names);
  ASSERT_TRUE(expression) << expression.error().message;
  const Result<std::vector<double>> all = expression->evaluate_all(points, 0.3, Threads(1));
  ASSERT_TRUE(all);
  for (const int threads : {2, 3, 8})
    EXPECT_EQ(*expression->evaluate_all(points, 0.3, Threads(threads)), *all);
  for (std::size_t i = 0; i < all->size(); ++i) {
    const Eigen::RowVector3d p = points.positions.row(static_cast<Eigen::Index>(i));
    const double expected = std::sin(3 * p.x()) * std::exp(p.y()) +
                            0.3 * points.body_coordinates(static_cast<Eigen::Index>(i), 0) +
                            points.body_coordinates(static_cast<Eigen::Index>(i), 1) + 7.5 * static_cast<double>(i);
    EXPECT_NEAR((*all)[i], expected, 1e-9 * (1 + std::abs(expected)));
  }
}

TEST(Expression, MissingBodyCoordinatesAndTakenNamesAreErrors) {
  RestPoints points = rod_points();
  points.body_coordinates.resize(0, 2);
  EXPECT_FALSE(Expression::compile("u")->evaluate_all(points, 0, Threads(1)));
  EXPECT_TRUE(Expression::compile("X")->evaluate_all(points, 0, Threads(1)));
  EXPECT_NE(error_of("1", {"t"}).find("'t'"), std::string::npos);
  EXPECT_NE(error_of("1", {"sin"}).find("'sin'"), std::string::npos);
  EXPECT_NE(error_of("1", {"a", "a"}).find("'a'"), std::string::npos);
  const std::vector<std::string> unspeakable = {"my colour", "a"};
  const Result<Expression> expression = Expression::compile("a", unspeakable);
  ASSERT_TRUE(expression);
  ExpressionPoint point;
  const double values[] = {1.0, 2.0};
  point.attributes = values;
  EXPECT_EQ(*expression->evaluate(point), 2.0);
  EXPECT_FALSE(expression->evaluate({}));
}

TEST(Expression, ManyThreadsShareOneFormula) {
  const Result<Expression> expression = Expression::compile("X*X + 1");
  ASSERT_TRUE(expression);
  std::vector<int> wrong(8, 0);
  std::vector<std::thread> threads;
  for (int k = 0; k < 8; ++k) {
    threads.emplace_back([&, k] {
      for (int i = 0; i < 2000; ++i) {
        ExpressionPoint point;
        point.position.x() = i + 10000 * k;
        wrong[k] += *expression->evaluate(point) != point.position.x() * point.position.x() + 1;
      }
    });
  }
  for (std::thread& thread : threads)
    thread.join();
  EXPECT_EQ(wrong, std::vector<int>(8, 0));
}

} // namespace
} // namespace wry::scene
