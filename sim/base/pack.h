#pragma once

#include <cstdint>

/// SIMD for kernel files (`*.kernel.cpp`, see wry_add_kernel): a Pack<T> holds WRY_ISA_BYTES of T and has the
/// arithmetic, comparison and choice (`mask ? a : b`) operators of GCC's vector types. Everything lives in the
/// namespace of the instruction set, so that no function compiled for one set can be linked into the code of another.
namespace wry::WRY_ISA {

template <class T> struct PackTraits {
  static constexpr int WIDTH = WRY_ISA_BYTES / static_cast<int>(sizeof(T));
  typedef T Vector __attribute__((vector_size(WRY_ISA_BYTES)));
  typedef Vector Memory __attribute__((may_alias));
};

template <class T> using Pack = typename PackTraits<T>::Vector;

using Real = Pack<double>;
using Bits = Pack<std::int64_t>;
inline constexpr int WIDTH = PackTraits<double>::WIDTH;

/// From and to memory aligned to the pack.
[[gnu::always_inline]] inline Real load(const double* from) {
  return *reinterpret_cast<const PackTraits<double>::Memory*>(from);
}
[[gnu::always_inline]] inline void store(double* to, Real value) {
  *reinterpret_cast<PackTraits<double>::Memory*>(to) = value;
}

[[gnu::always_inline]] inline Pack<float> load(const float* from) {
  return *reinterpret_cast<const PackTraits<float>::Memory*>(from);
}
[[gnu::always_inline]] inline void store(float* to, Pack<float> value) {
  *reinterpret_cast<PackTraits<float>::Memory*>(to) = value;
}

/// The same value in every lane.
[[gnu::always_inline]] inline Real broadcast(double value) {
  return Real{} + value;
}
/// The same for either scalar: splat<float>(x).
template <class T> [[gnu::always_inline]] inline Pack<T> splat(T value) {
  return Pack<T>{} + value;
}

/// Lane i is base[stride * index[i] + component].
[[gnu::always_inline]] inline Real gather(const double* base, const std::int32_t* index, int stride, int component) {
  Real values;
  for (int i = 0; i < WIDTH; ++i)
    values[i] = base[static_cast<std::int64_t>(stride) * index[i] + component];
  return values;
}

[[gnu::always_inline]] inline Real sqrt(Real x) {
  for (int i = 0; i < WIDTH; ++i)
    x[i] = __builtin_sqrt(x[i]);
  return x;
}

[[gnu::always_inline]] inline Real abs(Real x) {
  return reinterpret_cast<Real>(reinterpret_cast<Bits>(x) & INT64_MAX);
}
[[gnu::always_inline]] inline Real max(Real a, Real b) {
  return a > b ? a : b;
}
[[gnu::always_inline]] inline Real min(Real a, Real b) {
  return a < b ? a : b;
}

[[gnu::always_inline]] inline Pack<float> sqrt(Pack<float> x) {
  for (int i = 0; i < PackTraits<float>::WIDTH; ++i)
    x[i] = __builtin_sqrtf(x[i]);
  return x;
}
[[gnu::always_inline]] inline Pack<float> abs(Pack<float> x) {
  return reinterpret_cast<Pack<float>>(reinterpret_cast<Pack<std::int32_t>>(x) & INT32_MAX);
}
[[gnu::always_inline]] inline Pack<float> max(Pack<float> a, Pack<float> b) {
  return a > b ? a : b;
}
[[gnu::always_inline]] inline Pack<float> min(Pack<float> a, Pack<float> b) {
  return a < b ? a : b;
}

/// f - ln(1 + f) without cancellation for 1 + f in [sqrt(1/2), sqrt(2)]: the series of 2 artanh(s), s = f / (2 + f),
/// where 2 s = f - s f. Eleven terms leave 1e-17 of 2 s.
[[gnu::always_inline]] inline Real log_defect(Real f) {
  const Real s = f / (2.0 + f);
  const Real z = s * s;
  Real series = broadcast(1.0 / 23.0);
  series = series * z + 1.0 / 21.0;
  series = series * z + 1.0 / 19.0;
  series = series * z + 1.0 / 17.0;
  series = series * z + 1.0 / 15.0;
  series = series * z + 1.0 / 13.0;
  series = series * z + 1.0 / 11.0;
  series = series * z + 1.0 / 9.0;
  series = series * z + 1.0 / 7.0;
  series = series * z + 1.0 / 5.0;
  series = series * z + 1.0 / 3.0;
  return s * (f - 2.0 * z * series);
}

/// x = 2^exponent (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)), for normal positive x.
struct LogParts {
  Real exponent, f;
};
[[gnu::always_inline]] inline LogParts split_for_log(Real x) {
  // The exponent becomes a double by adding it to the mantissa of 1.5 * 2^52.
  constexpr std::int64_t ROOT_HALF = 0x3FE6A09E667F3BCD;
  constexpr std::int64_t MAGIC = 0x4338000000000000;
  const Bits bits = reinterpret_cast<Bits>(x);
  const Bits k = (bits - ROOT_HALF) >> 52;
  const Real one_and_f = reinterpret_cast<Real>(bits - (k << 52));
  return {reinterpret_cast<Real>(k + MAGIC) - reinterpret_cast<Real>(Bits{} + MAGIC), one_and_f - 1.0};
}

/// ln x from its parts and log_defect(f).
[[gnu::always_inline]] inline Real log_of_parts(const LogParts& parts, Real defect) {
  constexpr double LN2_HIGH = 0x1.62e42fefap-1; // 37 bits: exact times an exponent
  constexpr double LN2_LOW = 0x1.cf79abc9e3b3ap-40;
  return parts.exponent * LN2_HIGH + (parts.f - (defect - parts.exponent * LN2_LOW));
}

/// ln x of normal positive numbers, within 2 units in the last place; anything else gives an unspecified value.
[[gnu::always_inline]] inline Real log(Real x) {
  const LogParts parts = split_for_log(x);
  return log_of_parts(parts, log_defect(parts.f));
}

} // namespace wry::WRY_ISA
