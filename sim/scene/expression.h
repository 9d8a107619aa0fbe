#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/parallel.h"
#include "sim/base/result.h"
#include "sim/base/types.h"
#include "sim/scene/rest_points.h"

namespace wry::scene {

/// What a formula sees at one point.
struct ExpressionPoint {
  double time = 0;              ///< t [s]
  Vec3 position = Vec3::Zero(); ///< X, Y, Z: the rest position [m]
  double u = 0;                 ///< body coordinates in [0, 1]
  double v = 0;
  std::span<const double> attributes; ///< one per attribute name that the formula was compiled with
};

/// A formula of the shot file, compiled once, evaluated often, from any number of threads at once.
///
/// Variables: t, X, Y, Z, u, v and named attributes. Constant: pi. Operators: + - * / ^ (from the right), comparisons
/// and
/// && || (1 or 0), condition ? a : b. Functions: sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp
/// ln log (natural) log2 log10 sqrt abs sign rint floor ceil min max sum avg, and
///   smoothstep(a, b, x)  0 up to a, 1 from b on, 3 s^2 - 2 s^3 between
///   lerp(a, b, s)        a + (b - a) s, not limited
///   clamp(x, a, b)       x, but at least a and at most b
class Expression {
public:
  /// Errors: bad_input with the column, and for an unknown name the nearest known one. Assignments, strings and several
  /// results are refused, and formulas longer than 4096 characters.
  static Result<Expression> compile(std::string_view text, std::span<const std::string> attribute_names = {});

  /// Errors: bad_input when the value is not a finite number, or attributes are missing.
  Result<double> evaluate(const ExpressionPoint& point) const;

  /// The values at all points, for a formula compiled with component_names(points.attributes). Errors: as above, and
  /// when the formula uses u or v where the body has none; of several bad points the first is named.
  Result<std::vector<double>> evaluate_all(const RestPoints& points, double time, const Threads& threads) const;

  /// Whether the value depends on that variable.
  bool uses(std::string_view name) const;

  /// Whether it has the same value everywhere and always.
  bool is_constant() const;

  const std::string& text() const;

private:
  struct Content;
  explicit Expression(std::shared_ptr<Content> content)
      : m_content(std::move(content)) {}
  std::shared_ptr<Content> m_content;
};

} // namespace wry::scene
