#include "sim/scene/expression.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <mutex>
#include <numbers>

#include <muParser.h>

#include "sim/scene/expression_names.h"

namespace wry::scene {

namespace {

constexpr std::size_t MAX_LENGTH = 4096;
constexpr std::array<const char*, 6> VARIABLES = {"t", "X", "Y", "Z", "u", "v"};

double smoothstep(double a, double b, double x) {
  if (a == b)
    return x < a ? 0.0 : 1.0;
  const double s = std::clamp((x - a) / (b - a), 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

double lerp(double a, double b, double s) {
  return a + (b - a) * s;
}

double clamp(double x, double a, double b) {
  return std::min(std::max(x, a), b);
}

double floor_of(double x) {
  return std::floor(x);
}

double ceil_of(double x) {
  return std::ceil(x);
}

// A parser with variables of its own; muParser reads variables through pointers, so each thread that evaluates needs
// one.
class Evaluator {
public:
  explicit Evaluator(const std::vector<std::string>& attribute_names)
      : m_values(VARIABLES.size() + attribute_names.size(), 0.0) {
    m_parser.ClearConst();
    m_parser.DefineConst("pi", std::numbers::pi);
    m_parser.DefineFun("smoothstep", smoothstep);
    m_parser.DefineFun("lerp", lerp);
    m_parser.DefineFun("clamp", clamp);
    m_parser.DefineFun("floor", floor_of);
    m_parser.DefineFun("ceil", ceil_of);
    for (std::size_t i = 0; i < VARIABLES.size(); ++i)
      m_parser.DefineVar(VARIABLES[i], &m_values[i]);
    for (std::size_t i = 0; i < attribute_names.size(); ++i)
      m_parser.DefineVar(attribute_names[i], &m_values[VARIABLES.size() + i]);
  }
  Evaluator(const Evaluator&) = delete;
  Evaluator& operator=(const Evaluator&) = delete;

  mu::Parser& parser() { return m_parser; }

  double evaluate(const ExpressionPoint& point) {
    const double standard[] = {point.time, point.position.x(), point.position.y(), point.position.z(), point.u,
                               point.v};
    std::copy(std::begin(standard), std::end(standard), m_values.begin());
    std::copy_n(point.attributes.begin(), m_values.size() - VARIABLES.size(), m_values.begin() + VARIABLES.size());
    return m_parser.Eval();
  }

private:
  mu::Parser m_parser;
  std::vector<double> m_values;
};

ExpressionNames known_names(const mu::Parser& parser, const std::vector<std::string>& attribute_names) {
  ExpressionNames names;
  names.variables.assign(VARIABLES.begin(), VARIABLES.end());
  names.variables.insert(names.variables.end(), attribute_names.begin(), attribute_names.end());
  names.variables.emplace_back("pi");
  for (const auto& [name, function] : parser.GetFunDef())
    names.functions.push_back(name);
  return names;
}

Status check_attribute_names(const std::vector<std::string>& names, const mu::Parser& parser) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool is_taken = names[i] == "pi" ||
                          std::find(VARIABLES.begin(), VARIABLES.end(), names[i]) != VARIABLES.end() ||
                          parser.GetFunDef().count(names[i]) != 0 ||
                          std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) !=
                              names.begin() + static_cast<std::ptrdiff_t>(i);
    if (is_taken)
      return make_error(ErrorCode::bad_input, "the mesh attribute '{}' has a name that formulas use already; rename it",
                        names[i]);
  }
  return {};
}

std::string describe(const ExpressionPoint& point) {
  return fmt::format("t = {:.6g}, X = {:.6g}, Y = {:.6g}, Z = {:.6g}, u = {:.6g}, v = {:.6g}", point.time,
                     point.position.x(), point.position.y(), point.position.z(), point.u, point.v);
}

} // namespace

struct Expression::Content {
  std::string text;
  std::vector<std::string> attribute_names;  // those that a formula can name
  std::vector<std::size_t> attribute_places; // and where their values are
  std::size_t attribute_count = 0;
  std::vector<std::string> used;

  std::mutex mutex;
  std::deque<std::unique_ptr<Evaluator>> idle;

  Status prepare() {
    auto evaluator = std::make_unique<Evaluator>(attribute_names);
    if (Status status = check_attribute_names(attribute_names, evaluator->parser()); !status)
      return status;
    if (Status status = check_expression_names(text, known_names(evaluator->parser(), attribute_names)); !status)
      return make_error(ErrorCode::bad_input, "formula '{}', {}", text, status.error().message);
    try {
      evaluator->parser().SetExpr(text);
      int results = 0;
      evaluator->parser().Eval(results);
      if (results != 1)
        return make_error(ErrorCode::bad_input,
                          "formula '{}' gives {} values; it must give one (decimal point, not comma)", text, results);
      for (const auto& [name, value] : evaluator->parser().GetUsedVar())
        used.push_back(name);
    } catch (const mu::Parser::exception_type& error) {
      if (error.GetPos() >= 0)
        return make_error(ErrorCode::bad_input, "formula '{}', column {}: {}", text, error.GetPos() + 1,
                          error.GetMsg());
      return make_error(ErrorCode::bad_input, "formula '{}': {}", text, error.GetMsg());
    } catch (const std::exception& error) {
      return make_error(ErrorCode::bad_input, "formula '{}': {}", text, error.what());
    }
    idle.push_back(std::move(evaluator));
    return {};
  }

  std::unique_ptr<Evaluator> borrow() {
    {
      const std::lock_guard lock(mutex);
      if (!idle.empty()) {
        std::unique_ptr<Evaluator> evaluator = std::move(idle.back());
        idle.pop_back();
        return evaluator;
      }
    }
    auto evaluator = std::make_unique<Evaluator>(attribute_names);
    evaluator->parser().SetExpr(text);
    return evaluator;
  }

  void give_back(std::unique_ptr<Evaluator> evaluator) {
    const std::lock_guard lock(mutex);
    idle.push_back(std::move(evaluator));
  }

  // Calls body(evaluate) with evaluate(point); muParser throws only while it parses, and this formula has been parsed
  // before.
  template <class Body> void with_evaluator(const Body& body) {
    std::unique_ptr<Evaluator> evaluator = borrow();
    std::vector<double> attributes(attribute_places.size());
    body([&](ExpressionPoint point) {
      for (std::size_t i = 0; i < attributes.size(); ++i)
        attributes[i] = point.attributes[attribute_places[i]];
      point.attributes = attributes;
      return evaluator->evaluate(point);
    });
    give_back(std::move(evaluator));
  }

  Error not_finite(double value, const ExpressionPoint& point) const {
    return make_error(ErrorCode::bad_input, "formula '{}' gives {} at {}", text, value, describe(point));
  }
};

Result<Expression> Expression::compile(std::string_view text, std::span<const std::string> attribute_names) {
  if (text.size() > MAX_LENGTH)
    return make_error(ErrorCode::bad_input, "a formula of {} characters is too long; the limit is {}", text.size(),
                      MAX_LENGTH);
  auto content = std::make_shared<Content>();
  content->text = text;
  content->attribute_count = attribute_names.size();
  for (std::size_t i = 0; i < attribute_names.size(); ++i) {
    if (!is_expression_name(attribute_names[i]))
      continue;
    content->attribute_names.push_back(attribute_names[i]);
    content->attribute_places.push_back(i);
  }
  if (Status status = content->prepare(); !status)
    return status.error();
  return Expression(std::move(content));
}

Result<double> Expression::evaluate(const ExpressionPoint& point) const {
  if (point.attributes.size() < m_content->attribute_count)
    return make_error(ErrorCode::bad_input, "formula '{}' was compiled with {} attribute values, but {} are given",
                      text(), m_content->attribute_count, point.attributes.size());
  double value = 0;
  m_content->with_evaluator([&](const auto& evaluate_at) { value = evaluate_at(point); });
  if (!std::isfinite(value))
    return m_content->not_finite(value, point);
  return value;
}

Result<std::vector<double>> Expression::evaluate_all(const RestPoints& points, double time,
                                                     const Threads& threads) const {
  const auto count = static_cast<std::size_t>(points.positions.rows());
  const bool has_body_coordinates = points.body_coordinates.rows() == points.positions.rows();
  if (!has_body_coordinates && (uses("u") || uses("v")))
    return make_error(ErrorCode::bad_input, "formula '{}' uses {}, but only boxes, rods and sheets have u and v",
                      text(), uses("u") ? "u" : "v");
  std::size_t width = 0;
  for (const geometry::VertexAttribute& attribute : points.attributes)
    width += static_cast<std::size_t>(attribute.components);
  if (width != m_content->attribute_count)
    return make_error(ErrorCode::bad_input,
                      "formula '{}' was compiled with {} attribute values, but the points carry {}", text(),
                      m_content->attribute_count, width);

  const auto point_at = [&](std::size_t i, std::vector<double>& attributes) {
    const auto row = static_cast<Eigen::Index>(i);
    ExpressionPoint point;
    point.time = time;
    point.position = points.positions.row(row).transpose();
    if (has_body_coordinates) {
      point.u = points.body_coordinates(row, 0);
      point.v = points.body_coordinates(row, 1);
    }
    attributes.clear();
    for (const geometry::VertexAttribute& attribute : points.attributes)
      for (int k = 0; k < attribute.components; ++k)
        attributes.push_back(
            attribute.values[i * static_cast<std::size_t>(attribute.components) + static_cast<std::size_t>(k)]);
    point.attributes = attributes;
    return point;
  };
  std::vector<double> values(count);
  threads.for_chunks(count, 1024, [&](std::size_t begin, std::size_t end) {
    std::vector<double> attributes;
    m_content->with_evaluator([&](const auto& evaluate_at) {
      for (std::size_t i = begin; i < end; ++i)
        values[i] = evaluate_at(point_at(i, attributes));
    });
  });
  const auto bad = std::find_if(values.begin(), values.end(), [](double value) { return !std::isfinite(value); });
  if (bad != values.end()) {
    std::vector<double> attributes;
    return m_content->not_finite(*bad, point_at(static_cast<std::size_t>(bad - values.begin()), attributes));
  }
  return values;
}

bool Expression::uses(std::string_view name) const {
  return std::find(m_content->used.begin(), m_content->used.end(), name) != m_content->used.end();
}

bool Expression::is_constant() const {
  return m_content->used.empty();
}

const std::string& Expression::text() const {
  return m_content->text;
}

} // namespace wry::scene
