#pragma once

#include <cstdint>
#include <vector>

namespace wry::contact::test {

/// An exact number m 2^e with an integer m of any length: what doubles become under + - *.
class Dyadic {
public:
  Dyadic() = default;
  Dyadic(double value);

  int sign() const { return m_limbs.empty() ? 0 : m_negative ? -1 : 1; }
  Dyadic half() const;
  Dyadic operator-() const;
  friend Dyadic operator+(const Dyadic& a, const Dyadic& b);
  friend Dyadic operator-(const Dyadic& a, const Dyadic& b) { return a + (-b); }
  friend Dyadic operator*(const Dyadic& a, const Dyadic& b);
  friend bool operator<(const Dyadic& a, const Dyadic& b) { return (a - b).sign() < 0; }

private:
  using Limbs = std::vector<std::uint32_t>; ///< least first, no leading zeros
  static Limbs shifted(const Limbs& limbs, std::int64_t bits);
  static int compare(const Limbs& a, const Limbs& b);
  void trim();

  bool m_negative = false;
  std::int64_t m_exponent = 0;
  Limbs m_limbs;
};

/// Coefficients by rising power of t.
using Polynomial = std::vector<Dyadic>;
Polynomial operator+(const Polynomial& a, const Polynomial& b);
Polynomial operator-(const Polynomial& a, const Polynomial& b);
Polynomial operator*(const Polynomial& a, const Polynomial& b);
Dyadic evaluate(const Polynomial& polynomial, const Dyadic& t);
/// Its sign on all of [low, high], or 0 when that cannot be told from the middle and a bound on the slope.
int sign_on(const Polynomial& polynomial, const Dyadic& low, const Dyadic& high);

struct RootInterval {
  Dyadic low, high;
};
/// Intervals of the width 2^-depth, ascending, that contain all roots of a cubic in [0, 1].
std::vector<RootInterval> isolate_roots(const Polynomial& cubic, int depth);

} // namespace wry::contact::test
