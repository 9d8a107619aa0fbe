#include "tests/contact/dyadic_support.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace wry::contact::test {

Dyadic::Dyadic(double value) {
  if (value == 0.0)
    return;
  int exponent = 0;
  const double mantissa = std::frexp(std::abs(value), &exponent);
  const auto integer = static_cast<std::uint64_t>(std::ldexp(mantissa, 53));
  m_negative = value < 0.0;
  m_exponent = exponent - 53;
  m_limbs = {static_cast<std::uint32_t>(integer), static_cast<std::uint32_t>(integer >> 32)};
  trim();
}

void Dyadic::trim() {
  while (!m_limbs.empty() && m_limbs.back() == 0)
    m_limbs.pop_back();
  std::size_t zeros = 0;
  while (zeros < m_limbs.size() && m_limbs[zeros] == 0)
    ++zeros;
  m_limbs.erase(m_limbs.begin(), m_limbs.begin() + static_cast<std::ptrdiff_t>(zeros));
  m_exponent += static_cast<std::int64_t>(zeros) * 32;
}

Dyadic Dyadic::half() const {
  Dyadic result = *this;
  --result.m_exponent;
  return result;
}

Dyadic Dyadic::operator-() const {
  Dyadic result = *this;
  result.m_negative = !m_negative;
  return result;
}

Dyadic::Limbs Dyadic::shifted(const Limbs& limbs, std::int64_t bits) {
  Limbs out(static_cast<std::size_t>(bits / 32), 0);
  const int rest = static_cast<int>(bits % 32);
  std::uint64_t carry = 0;
  for (const std::uint32_t limb : limbs) {
    carry |= static_cast<std::uint64_t>(limb) << rest;
    out.push_back(static_cast<std::uint32_t>(carry));
    carry >>= 32;
  }
  out.push_back(static_cast<std::uint32_t>(carry));
  while (!out.empty() && out.back() == 0)
    out.pop_back();
  return out;
}

int Dyadic::compare(const Limbs& a, const Limbs& b) {
  if (a.size() != b.size())
    return a.size() < b.size() ? -1 : 1;
  for (std::size_t i = a.size(); i-- > 0;) {
    if (a[i] != b[i])
      return a[i] < b[i] ? -1 : 1;
  }
  return 0;
}

Dyadic operator+(const Dyadic& a, const Dyadic& b) {
  if (a.sign() == 0)
    return b;
  if (b.sign() == 0)
    return a;
  Dyadic sum;
  sum.m_exponent = std::min(a.m_exponent, b.m_exponent);
  Dyadic::Limbs large = Dyadic::shifted(a.m_limbs, a.m_exponent - sum.m_exponent);
  Dyadic::Limbs small = Dyadic::shifted(b.m_limbs, b.m_exponent - sum.m_exponent);
  bool negative = a.m_negative;
  if (Dyadic::compare(large, small) < 0) {
    std::swap(large, small);
    negative = b.m_negative;
  }
  sum.m_negative = negative;
  const bool add = a.m_negative == b.m_negative;
  std::int64_t carry = 0;
  for (std::size_t i = 0; i < large.size(); ++i) {
    const std::int64_t other = i < small.size() ? static_cast<std::int64_t>(small[i]) : 0;
    carry += static_cast<std::int64_t>(large[i]) + (add ? other : -other);
    large[i] = static_cast<std::uint32_t>(carry);
    carry >>= 32;
  }
  if (carry > 0)
    large.push_back(static_cast<std::uint32_t>(carry));
  sum.m_limbs = std::move(large);
  sum.trim();
  return sum;
}

Dyadic operator*(const Dyadic& a, const Dyadic& b) {
  Dyadic product;
  if (a.sign() == 0 || b.sign() == 0)
    return product;
  product.m_negative = a.m_negative != b.m_negative;
  product.m_exponent = a.m_exponent + b.m_exponent;
  product.m_limbs.assign(a.m_limbs.size() + b.m_limbs.size(), 0);
  for (std::size_t i = 0; i < a.m_limbs.size(); ++i) {
    std::uint64_t carry = 0;
    for (std::size_t j = 0; j < b.m_limbs.size(); ++j) {
      carry += static_cast<std::uint64_t>(a.m_limbs[i]) * b.m_limbs[j] + product.m_limbs[i + j];
      product.m_limbs[i + j] = static_cast<std::uint32_t>(carry);
      carry >>= 32;
    }
    product.m_limbs[i + b.m_limbs.size()] = static_cast<std::uint32_t>(carry);
  }
  product.trim();
  return product;
}

Polynomial operator+(const Polynomial& a, const Polynomial& b) {
  Polynomial sum(std::max(a.size(), b.size()));
  for (std::size_t i = 0; i < sum.size(); ++i)
    sum[i] = (i < a.size() ? a[i] : Dyadic()) + (i < b.size() ? b[i] : Dyadic());
  return sum;
}

Polynomial operator-(const Polynomial& a, const Polynomial& b) {
  Polynomial negative = b;
  for (Dyadic& coefficient : negative)
    coefficient = -coefficient;
  return a + negative;
}

Polynomial operator*(const Polynomial& a, const Polynomial& b) {
  Polynomial product(a.size() + b.size() - 1);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j)
      product[i + j] = product[i + j] + a[i] * b[j];
  }
  return product;
}

Dyadic evaluate(const Polynomial& polynomial, const Dyadic& t) {
  Dyadic value;
  for (std::size_t i = polynomial.size(); i-- > 0;)
    value = value * t + polynomial[i];
  return value;
}

int sign_on(const Polynomial& polynomial, const Dyadic& low, const Dyadic& high) {
  const Dyadic middle = (low + high).half();
  const Dyadic value = evaluate(polynomial, middle);
  Dyadic slope; // on [0, 1]: the sum of i |c_i|
  for (std::size_t i = 1; i < polynomial.size(); ++i)
    slope = slope + Dyadic(static_cast<double>(i)) * (polynomial[i].sign() < 0 ? -polynomial[i] : polynomial[i]);
  const Dyadic size = value.sign() < 0 ? -value : value;
  return (high - low) * slope < size ? value.sign() : 0;
}

namespace {

using Bernstein = std::array<Dyadic, 4>;

void isolate(const Bernstein& b, const Dyadic& low, const Dyadic& width, int depth, std::vector<RootInterval>& out) {
  // The values lie between the coefficients: all of one sign, no root.
  bool positive = true;
  bool negative = true;
  for (const Dyadic& coefficient : b) {
    positive = positive && coefficient.sign() > 0;
    negative = negative && coefficient.sign() < 0;
  }
  if (positive || negative)
    return;
  if (depth == 0) {
    out.push_back({low, low + width});
    return;
  }
  const Dyadic ab = (b[0] + b[1]).half();
  const Dyadic bc = (b[1] + b[2]).half();
  const Dyadic cd = (b[2] + b[3]).half();
  const Dyadic abc = (ab + bc).half();
  const Dyadic bcd = (bc + cd).half();
  const Dyadic middle = (abc + bcd).half();
  isolate({b[0], ab, abc, middle}, low, width.half(), depth - 1, out);
  isolate({middle, bcd, cd, b[3]}, low + width.half(), width.half(), depth - 1, out);
}

} // namespace

std::vector<RootInterval> isolate_roots(const Polynomial& c, int depth) {
  // Three times the Bernstein coefficients, so that they stay dyadic.
  const Dyadic three(3.0);
  const Bernstein b = {three * c[0], three * c[0] + c[1], three * c[0] + Dyadic(2.0) * c[1] + c[2],
                       three * (c[0] + c[1] + c[2] + c[3])};
  std::vector<RootInterval> roots;
  isolate(b, Dyadic(0.0), Dyadic(1.0), depth, roots);
  return roots;
}

} // namespace wry::contact::test
