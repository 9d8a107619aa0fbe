#pragma once

#include "sim/base/pack.h"

#define WRY_INLINE [[gnu::always_inline]] inline

/// Small tensors and functions of packs of float or double, for the kernels of matter. Members are named, not indexed,
/// so that they live in registers.
namespace wry::mpm::WRY_ISA {

using wry::WRY_ISA::Pack;
using wry::WRY_ISA::PackTraits;

template <class P> struct LaneTraits;
template <> struct LaneTraits<Pack<float>> {
  using Scalar = float;
  using Bits = Pack<std::int32_t>;
  static constexpr float EPSILON = 0x1p-23f;
  static constexpr int LOG_TERMS = 5, EXP_TERMS = 7, SIN_TERMS = 6;
  static constexpr int MANTISSA_BITS = 23;
  static constexpr std::int32_t ROOT_HALF = 0x3F3504F3, MAGIC = 0x4B400000; // 1.5 * 2^23
  static constexpr float LN2_HIGH = 0x1.62ep-1f, LN2_LOW = 0x1.0bfbe8p-15f;
};
template <> struct LaneTraits<Pack<double>> {
  using Scalar = double;
  using Bits = Pack<std::int64_t>;
  static constexpr double EPSILON = 0x1p-52;
  static constexpr int LOG_TERMS = 11, EXP_TERMS = 13, SIN_TERMS = 11;
  static constexpr int MANTISSA_BITS = 52;
  static constexpr std::int64_t ROOT_HALF = 0x3FE6A09E667F3BCD, MAGIC = 0x4338000000000000; // 1.5 * 2^52
  static constexpr double LN2_HIGH = 0x1.62e42fefap-1, LN2_LOW = 0x1.cf79abc9e3b3ap-40;
};
template <class P> using ScalarOf = typename LaneTraits<P>::Scalar;
template <class P> using MaskOf = typename LaneTraits<P>::Bits;
template <class P> inline constexpr int LANES_OF = static_cast<int>(sizeof(P) / sizeof(ScalarOf<P>));

template <class P> WRY_INLINE P load_lanes(const ScalarOf<P>* from) {
  return *reinterpret_cast<const typename PackTraits<ScalarOf<P>>::Memory*>(from);
}
template <class P> WRY_INLINE void store_lanes(ScalarOf<P>* to, P value) {
  *reinterpret_cast<typename PackTraits<ScalarOf<P>>::Memory*>(to) = value;
}
/// The same value in every lane.
template <class P> WRY_INLINE P all_lanes(double value) {
  return P{} + static_cast<ScalarOf<P>>(value);
}

WRY_INLINE Pack<float> root(Pack<float> x) {
  for (int i = 0; i < LANES_OF<Pack<float>>; ++i)
    x[i] = __builtin_sqrtf(x[i]);
  return x;
}
WRY_INLINE Pack<double> root(Pack<double> x) {
  for (int i = 0; i < LANES_OF<Pack<double>>; ++i)
    x[i] = __builtin_sqrt(x[i]);
  return x;
}
template <class P> WRY_INLINE P magnitude(P x) {
  return x < 0 ? -x : x;
}
template <class P> WRY_INLINE P larger(P a, P b) {
  return a > b ? a : b;
}
template <class P> WRY_INLINE P smaller(P a, P b) {
  return a < b ? a : b;
}
template <class M> WRY_INLINE bool any_lane(M mask) {
  bool any = false;
  for (int i = 0; i < static_cast<int>(sizeof(M) / sizeof(mask[0])); ++i)
    any |= mask[i] != 0;
  return any;
}

/// e^x of |x| < 80, within 2 units in the last place.
template <class P> WRY_INLINE P exponential(P x) {
  using Traits = LaneTraits<P>;
  using Bits = typename Traits::Bits;
  using T = ScalarOf<P>;
  const P magic = reinterpret_cast<P>(Bits{} + Traits::MAGIC);
  const P shifted = x * static_cast<T>(1.4426950408889634) + magic;
  const Bits exponent = reinterpret_cast<Bits>(shifted) - Traits::MAGIC;
  const P n = shifted - magic;
  const P r = (x - n * Traits::LN2_HIGH) - n * Traits::LN2_LOW;
  P sum = all_lanes<P>(1.0);
  for (int k = Traits::EXP_TERMS; k > 0; --k)
    sum = sum * r * static_cast<T>(1.0 / k) + static_cast<T>(1);
  return reinterpret_cast<P>(reinterpret_cast<Bits>(sum) + (exponent << Traits::MANTISSA_BITS));
}

/// ln x of normal positive numbers, within 2 units in the last place.
template <class P> WRY_INLINE P logarithm(P x) {
  using Traits = LaneTraits<P>;
  using Bits = typename Traits::Bits;
  using T = ScalarOf<P>;
  const Bits bits = reinterpret_cast<Bits>(x);
  const Bits k = (bits - Traits::ROOT_HALF) >> Traits::MANTISSA_BITS;
  const P f = reinterpret_cast<P>(bits - (k << Traits::MANTISSA_BITS)) - static_cast<T>(1);
  const P n = reinterpret_cast<P>(k + Traits::MAGIC) - reinterpret_cast<P>(Bits{} + Traits::MAGIC);
  const P s = f / (f + static_cast<T>(2)), z = s * s;
  P series = all_lanes<P>(1.0 / (2 * Traits::LOG_TERMS + 1));
  for (int term = Traits::LOG_TERMS - 1; term > 0; --term)
    series = series * z + static_cast<T>(1.0 / (2 * term + 1));
  const P defect = s * (f - static_cast<T>(2) * z * series);
  return n * Traits::LN2_HIGH + (f - (defect - n * Traits::LN2_LOW));
}

/// sin x of |x| <= pi / 2.
template <class P> WRY_INLINE P sine(P x) {
  using T = ScalarOf<P>;
  const P z = x * x;
  P sum = all_lanes<P>(1.0);
  for (int k = LaneTraits<P>::SIN_TERMS; k > 0; --k)
    sum = static_cast<T>(1) - z * sum * static_cast<T>(1.0 / ((2 * k) * (2 * k + 1)));
  return x * sum;
}

template <class P> struct Vec { P x, y, z; };
template <class P> WRY_INLINE P dot(const Vec<P>& a, const Vec<P>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class P> WRY_INLINE P sum(const Vec<P>& a) {
  return a.x + a.y + a.z;
}
template <class P> WRY_INLINE Vec<P> operator*(P s, const Vec<P>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class P> WRY_INLINE Vec<P> operator+(const Vec<P>& a, const Vec<P>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class P> WRY_INLINE Vec<P> operator-(const Vec<P>& a, const Vec<P>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class M, class P> WRY_INLINE Vec<P> choose(M mask, const Vec<P>& a, const Vec<P>& b) {
  return {mask ? a.x : b.x, mask ? a.y : b.y, mask ? a.z : b.z};
}

/// Rows.
template <class P> struct Mat { Vec<P> r0, r1, r2; };
template <class P> WRY_INLINE Mat<P> transposed(const Mat<P>& a) {
  return {{a.r0.x, a.r1.x, a.r2.x}, {a.r0.y, a.r1.y, a.r2.y}, {a.r0.z, a.r1.z, a.r2.z}};
}
/// a^T b
template <class P> WRY_INLINE Vec<P> transposed_times(const Mat<P>& a, const Vec<P>& b) {
  return b.x * a.r0 + b.y * a.r1 + b.z * a.r2;
}
template <class P> WRY_INLINE Mat<P> operator*(const Mat<P>& a, const Mat<P>& b) {
  return {transposed_times(b, a.r0), transposed_times(b, a.r1), transposed_times(b, a.r2)};
}
template <class P> WRY_INLINE Vec<P> cross(const Vec<P>& a, const Vec<P>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class P> WRY_INLINE P determinant(const Mat<P>& a) {
  return dot(a.r0, cross(a.r1, a.r2));
}
template <class M, class P> WRY_INLINE Mat<P> choose(M mask, const Mat<P>& a, const Mat<P>& b) {
  return {choose(mask, a.r0, b.r0), choose(mask, a.r1, b.r1), choose(mask, a.r2, b.r2)};
}

/// Symmetric, in the order of a stress channel.
template <class P> struct Sym { P xx, yy, zz, yz, zx, xy; };
template <class P> WRY_INLINE Sym<P> operator+(const Sym<P>& a, const Sym<P>& b) {
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.yz + b.yz, a.zx + b.zx, a.xy + b.xy};
}
template <class P> WRY_INLINE Sym<P> operator-(const Sym<P>& a, const Sym<P>& b) {
  return {a.xx - b.xx, a.yy - b.yy, a.zz - b.zz, a.yz - b.yz, a.zx - b.zx, a.xy - b.xy};
}
template <class P> WRY_INLINE Sym<P> operator*(P s, const Sym<P>& a) {
  return {s * a.xx, s * a.yy, s * a.zz, s * a.yz, s * a.zx, s * a.xy};
}
template <class P> WRY_INLINE Sym<P> plus_identity(const Sym<P>& a, P s) {
  return {a.xx + s, a.yy + s, a.zz + s, a.yz, a.zx, a.xy};
}
template <class P> WRY_INLINE P trace(const Sym<P>& a) {
  return a.xx + a.yy + a.zz;
}
/// a : b
template <class P> WRY_INLINE P contracted(const Sym<P>& a, const Sym<P>& b) {
  const P off = a.yz * b.yz + a.zx * b.zx + a.xy * b.xy;
  return a.xx * b.xx + a.yy * b.yy + a.zz * b.zz + (off + off);
}
template <class P> WRY_INLINE P determinant(const Sym<P>& a) {
  return a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.yz * a.zx) + a.zx * (a.xy * a.yz - a.yy * a.zx);
}
template <class P> WRY_INLINE Sym<P> adjugate(const Sym<P>& a) {
  return {a.yy * a.zz - a.yz * a.yz, a.xx * a.zz - a.zx * a.zx, a.xx * a.yy - a.xy * a.xy,
          a.zx * a.xy - a.xx * a.yz, a.xy * a.yz - a.yy * a.zx, a.yz * a.zx - a.zz * a.xy};
}
/// a b of matrices with the same axes: symmetric again.
template <class P> WRY_INLINE Sym<P> coaxial_product(const Sym<P>& a, const Sym<P>& b) {
  return {a.xx * b.xx + a.xy * b.xy + a.zx * b.zx, a.xy * b.xy + a.yy * b.yy + a.yz * b.yz,
          a.zx * b.zx + a.yz * b.yz + a.zz * b.zz, a.xy * b.zx + a.yy * b.yz + a.yz * b.zz,
          a.zx * b.xx + a.yz * b.xy + a.zz * b.zx, a.xx * b.xy + a.xy * b.yy + a.zx * b.yz};
}
template <class M, class P> WRY_INLINE Sym<P> choose(M mask, const Sym<P>& a, const Sym<P>& b) {
  return {mask ? a.xx : b.xx, mask ? a.yy : b.yy, mask ? a.zz : b.zz,
          mask ? a.yz : b.yz, mask ? a.zx : b.zx, mask ? a.xy : b.xy};
}
template <class P> WRY_INLINE Mat<P> as_matrix(const Sym<P>& a) {
  return {{a.xx, a.xy, a.zx}, {a.xy, a.yy, a.yz}, {a.zx, a.yz, a.zz}};
}
/// m m^T
template <class P> WRY_INLINE Sym<P> gram(const Mat<P>& m) {
  return {dot(m.r0, m.r0), dot(m.r1, m.r1), dot(m.r2, m.r2), dot(m.r1, m.r2), dot(m.r2, m.r0), dot(m.r0, m.r1)};
}
/// The symmetric part.
template <class P> WRY_INLINE Sym<P> symmetric_part(const Mat<P>& m) {
  const P half = all_lanes<P>(0.5);
  return {m.r0.x, m.r1.y, m.r2.z, half * (m.r1.z + m.r2.y), half * (m.r2.x + m.r0.z), half * (m.r0.y + m.r1.x)};
}
/// q s q^T
template <class P> WRY_INLINE Sym<P> congruent(const Mat<P>& q, const Sym<P>& s) {
  const Mat<P> m = q * as_matrix(s);
  return {dot(m.r0, q.r0), dot(m.r1, q.r1), dot(m.r2, q.r2), dot(m.r1, q.r2), dot(m.r2, q.r0), dot(m.r0, q.r1)};
}
/// axes diag(values) axes^T, the axes being columns.
template <class P> WRY_INLINE Sym<P> spectral(const Mat<P>& axes, const Vec<P>& v) {
  const auto scaled = [&v](const Vec<P>& row) { return Vec<P>{row.x * v.x, row.y * v.y, row.z * v.z}; };
  const Vec<P> m0 = scaled(axes.r0), m1 = scaled(axes.r1), m2 = scaled(axes.r2);
  return {dot(m0, axes.r0), dot(m1, axes.r1), dot(m2, axes.r2), dot(m1, axes.r2), dot(m2, axes.r0), dot(m0, axes.r1)};
}

/// Unit quaternion.
template <class P> struct Quat { P w, x, y, z; };
template <class P> WRY_INLINE Quat<P> operator*(const Quat<P>& a, const Quat<P>& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z, a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x};
}
template <class P> WRY_INLINE Quat<P> unit(const Quat<P>& q) {
  const P s = all_lanes<P>(1.0) / root(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {s * q.w, s * q.x, s * q.y, s * q.z};
}
template <class P> WRY_INLINE Mat<P> rotation(const Quat<P>& q) {
  const P two = all_lanes<P>(2.0), one = all_lanes<P>(1.0);
  const P xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, yz = q.y * q.z, zx = q.z * q.x;
  const P wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{one - two * (yy + zz), two * (xy - wz), two * (zx + wy)},
          {two * (xy + wz), one - two * (xx + zz), two * (yz - wx)},
          {two * (zx - wy), two * (yz + wx), one - two * (xx + yy)}};
}
/// Of a rotation by less than a half turn.
template <class P> WRY_INLINE Quat<P> quaternion_of(const Mat<P>& r) {
  const P w =
      r.r0.x + r.r1.y + r.r2.z + static_cast<ScalarOf<P>>(1); // (1 + tr) = 4 w^2; the rest is 4 w times the axis
  return unit(Quat<P>{w, r.r2.y - r.r1.z, r.r0.z - r.r2.x, r.r1.x - r.r0.y});
}

template <class P> WRY_INLINE Mat<P> load_matrix(const ScalarOf<P>* from, int stride) {
  const auto at = [from, stride](int i) { return load_lanes<P>(from + i * stride); };
  return {{at(0), at(1), at(2)}, {at(3), at(4), at(5)}, {at(6), at(7), at(8)}};
}
template <class P> WRY_INLINE void store_matrix(ScalarOf<P>* to, int stride, const Mat<P>& m) {
  const P entries[9] = {m.r0.x, m.r0.y, m.r0.z, m.r1.x, m.r1.y, m.r1.z, m.r2.x, m.r2.y, m.r2.z};
  for (int i = 0; i < 9; ++i)
    store_lanes<P>(to + i * stride, entries[i]);
}
template <class P> WRY_INLINE Sym<P> load_symmetric(const ScalarOf<P>* from, int stride) {
  const auto at = [from, stride](int i) { return load_lanes<P>(from + i * stride); };
  return {at(0), at(1), at(2), at(3), at(4), at(5)};
}
template <class P> WRY_INLINE void store_symmetric(ScalarOf<P>* to, int stride, const Sym<P>& s) {
  const P entries[6] = {s.xx, s.yy, s.zz, s.yz, s.zx, s.xy};
  for (int i = 0; i < 6; ++i)
    store_lanes<P>(to + i * stride, entries[i]);
}
template <class P> WRY_INLINE Quat<P> load_quaternion(const ScalarOf<P>* from, int stride) {
  const auto at = [from, stride](int i) { return load_lanes<P>(from + i * stride); };
  return {at(0), at(1), at(2), at(3)};
}
template <class P> WRY_INLINE void store_quaternion(ScalarOf<P>* to, int stride, const Quat<P>& q) {
  const P entries[4] = {q.w, q.x, q.y, q.z};
  for (int i = 0; i < 4; ++i)
    store_lanes<P>(to + i * stride, entries[i]);
}

} // namespace wry::mpm::WRY_ISA
