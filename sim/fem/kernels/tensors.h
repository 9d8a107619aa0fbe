#pragma once

#include "sim/base/pack.h"
#include "sim/fem/kernels/batch.h"

#define WRY_INLINE [[gnu::always_inline]] inline

/// Small tensors of packs for kernel files. Members are named, not indexed, so that they live in registers.
namespace wry::fem::WRY_ISA {

using wry::WRY_ISA::Bits;
using wry::WRY_ISA::broadcast;
using wry::WRY_ISA::gather;
using wry::WRY_ISA::load;
using wry::WRY_ISA::log;
using wry::WRY_ISA::log_defect;
using wry::WRY_ISA::log_of_parts;
using wry::WRY_ISA::LogParts;
using wry::WRY_ISA::Real;
using wry::WRY_ISA::split_for_log;
using wry::WRY_ISA::sqrt;
using wry::WRY_ISA::store;
using wry::WRY_ISA::WIDTH;

struct Vec {
  Real x, y, z;
};

WRY_INLINE Vec operator+(const Vec& a, const Vec& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
WRY_INLINE Vec operator-(const Vec& a, const Vec& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
WRY_INLINE Vec operator-(const Vec& a) {
  return {-a.x, -a.y, -a.z};
}
WRY_INLINE Vec operator*(Real s, const Vec& a) {
  return {s * a.x, s * a.y, s * a.z};
}
WRY_INLINE Real dot(const Vec& a, const Vec& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
WRY_INLINE Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Rows.
struct Mat {
  Vec r0, r1, r2;
};

WRY_INLINE Mat operator+(const Mat& a, const Mat& b) {
  return {a.r0 + b.r0, a.r1 + b.r1, a.r2 + b.r2};
}
WRY_INLINE Mat operator-(const Mat& a, const Mat& b) {
  return {a.r0 - b.r0, a.r1 - b.r1, a.r2 - b.r2};
}
WRY_INLINE Mat operator-(const Mat& a) {
  return {-a.r0, -a.r1, -a.r2};
}
WRY_INLINE Mat operator*(Real s, const Mat& a) {
  return {s * a.r0, s * a.r1, s * a.r2};
}
WRY_INLINE Vec operator*(const Mat& a, const Vec& b) {
  return {dot(a.r0, b), dot(a.r1, b), dot(a.r2, b)};
}
/// a^T b
WRY_INLINE Vec transposed_times(const Mat& a, const Vec& b) {
  return b.x * a.r0 + b.y * a.r1 + b.z * a.r2;
}
WRY_INLINE Mat transposed(const Mat& a) {
  return {{a.r0.x, a.r1.x, a.r2.x}, {a.r0.y, a.r1.y, a.r2.y}, {a.r0.z, a.r1.z, a.r2.z}};
}
WRY_INLINE Mat operator*(const Mat& a, const Mat& b) {
  return {transposed_times(b, a.r0), transposed_times(b, a.r1), transposed_times(b, a.r2)};
}
WRY_INLINE Mat outer(const Vec& a, const Vec& b) {
  return {a.x * b, a.y * b, a.z * b};
}
/// a + s I
WRY_INLINE Mat plus_identity(const Mat& a, Real s) {
  return {{a.r0.x + s, a.r0.y, a.r0.z}, {a.r1.x, a.r1.y + s, a.r1.z}, {a.r2.x, a.r2.y, a.r2.z + s}};
}
/// a + cross(b), where cross(b) c = b x c
WRY_INLINE Mat plus_cross(const Mat& a, const Vec& b) {
  return {
      {a.r0.x, a.r0.y - b.z, a.r0.z + b.y}, {a.r1.x + b.z, a.r1.y, a.r1.z - b.x}, {a.r2.x - b.y, a.r2.y + b.x, a.r2.z}};
}
/// a - cross(b)
WRY_INLINE Mat minus_cross(const Mat& a, const Vec& b) {
  return {
      {a.r0.x, a.r0.y + b.z, a.r0.z - b.y}, {a.r1.x - b.z, a.r1.y, a.r1.z + b.x}, {a.r2.x + b.y, a.r2.y - b.x, a.r2.z}};
}
/// cross(a) b
WRY_INLINE Mat cross(const Vec& a, const Mat& b) {
  return {a.y * b.r2 - a.z * b.r1, a.z * b.r0 - a.x * b.r2, a.x * b.r1 - a.y * b.r0};
}
WRY_INLINE Real trace(const Mat& a) {
  return a.r0.x + a.r1.y + a.r2.z;
}
/// twice the axial vector of the skew part
WRY_INLINE Vec axial(const Mat& a) {
  return {a.r2.y - a.r1.z, a.r0.z - a.r2.x, a.r1.x - a.r0.y};
}

/// Symmetric.
struct Sym {
  Real xx, xy, xz, yy, yz, zz;
};

WRY_INLINE Sym operator+(const Sym& a, const Sym& b) {
  return {a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yy + b.yy, a.yz + b.yz, a.zz + b.zz};
}
WRY_INLINE Sym operator-(const Sym& a, const Sym& b) {
  return {a.xx - b.xx, a.xy - b.xy, a.xz - b.xz, a.yy - b.yy, a.yz - b.yz, a.zz - b.zz};
}
WRY_INLINE Sym operator*(Real s, const Sym& a) {
  return {s * a.xx, s * a.xy, s * a.xz, s * a.yy, s * a.yz, s * a.zz};
}
WRY_INLINE Vec operator*(const Sym& a, const Vec& b) {
  return {a.xx * b.x + a.xy * b.y + a.xz * b.z, a.xy * b.x + a.yy * b.y + a.yz * b.z,
          a.xz * b.x + a.yz * b.y + a.zz * b.z};
}
/// (a + a^T) / 2
WRY_INLINE Sym symmetric_part(const Mat& a) {
  return {a.r0.x, 0.5 * (a.r0.y + a.r1.x), 0.5 * (a.r0.z + a.r2.x), a.r1.y, 0.5 * (a.r1.z + a.r2.y), a.r2.z};
}
/// a a^T
WRY_INLINE Sym square(const Vec& a) {
  return {a.x * a.x, a.x * a.y, a.x * a.z, a.y * a.y, a.y * a.z, a.z * a.z};
}
/// s a a^T
WRY_INLINE Sym square_scaled(Real s, const Vec& a) {
  const Vec b = s * a;
  return {b.x * a.x, b.x * a.y, b.x * a.z, b.y * a.y, b.y * a.z, b.z * a.z};
}
/// a b^T + b a^T
WRY_INLINE Sym symmetric_outer(const Vec& a, const Vec& b) {
  return {2.0 * a.x * b.x, a.x * b.y + a.y * b.x, a.x * b.z + a.z * b.x,
          2.0 * a.y * b.y, a.y * b.z + a.z * b.y, 2.0 * a.z * b.z};
}
/// a a^T
WRY_INLINE Sym square(const Mat& a) {
  return {dot(a.r0, a.r0), dot(a.r0, a.r1), dot(a.r0, a.r2), dot(a.r1, a.r1), dot(a.r1, a.r2), dot(a.r2, a.r2)};
}
WRY_INLINE Sym plus_identity(const Sym& a, Real s) {
  return {a.xx + s, a.xy, a.xz, a.yy + s, a.yz, a.zz + s};
}
WRY_INLINE Mat full(const Sym& a) {
  return {{a.xx, a.xy, a.xz}, {a.xy, a.yy, a.yz}, {a.xz, a.yz, a.zz}};
}

/// A quaternion, or any vector of its space.
struct Quat {
  Real w, x, y, z;
};

WRY_INLINE Quat operator+(const Quat& a, const Quat& b) {
  return {a.w + b.w, a.x + b.x, a.y + b.y, a.z + b.z};
}
WRY_INLINE Quat operator-(const Quat& a, const Quat& b) {
  return {a.w - b.w, a.x - b.x, a.y - b.y, a.z - b.z};
}
WRY_INLINE Quat operator-(const Quat& a) {
  return {-a.w, -a.x, -a.y, -a.z};
}
WRY_INLINE Quat operator*(Real s, const Quat& a) {
  return {s * a.w, s * a.x, s * a.y, s * a.z};
}
WRY_INLINE Real dot(const Quat& a, const Quat& b) {
  return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
}
/// Hamilton product
WRY_INLINE Quat operator*(const Quat& a, const Quat& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z, a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x};
}
/// (0, a) b
WRY_INLINE Quat operator*(const Vec& a, const Quat& b) {
  return {-(a.x * b.x + a.y * b.y + a.z * b.z), a.x * b.w + a.y * b.z - a.z * b.y, a.y * b.w + a.z * b.x - a.x * b.z,
          a.z * b.w + a.x * b.y - a.y * b.x};
}
/// a (0, b)
WRY_INLINE Quat operator*(const Quat& a, const Vec& b) {
  return {-(a.x * b.x + a.y * b.y + a.z * b.z), a.w * b.x + a.y * b.z - a.z * b.y, a.w * b.y + a.z * b.x - a.x * b.z,
          a.w * b.z + a.x * b.y - a.y * b.x};
}
WRY_INLINE Quat conjugate(const Quat& q) {
  return {q.w, -q.x, -q.y, -q.z};
}
WRY_INLINE Vec vector_part(const Quat& q) {
  return {q.x, q.y, q.z};
}
/// |q|^2 times the rotation matrix of q (spec §1)
WRY_INLINE Mat scaled_rotation(const Quat& q) {
  const Real x2 = 2.0 * q.x, y2 = 2.0 * q.y, z2 = 2.0 * q.z, w2 = 2.0 * q.w;
  const Real diagonal = q.w * q.w - q.x * q.x - q.y * q.y - q.z * q.z;
  const Real xy = x2 * q.y, xz = x2 * q.z, yz = y2 * q.z;
  return {{diagonal + x2 * q.x, xy - w2 * q.z, xz + w2 * q.y},
          {xy + w2 * q.z, diagonal + y2 * q.y, yz - w2 * q.x},
          {xz - w2 * q.y, yz + w2 * q.x, diagonal + z2 * q.z}};
}

/// Entries that follow each other in a batch, and rows of fields on nodes.
WRY_INLINE Vec load_vec(const double* entries) {
  return {load(entries), load(entries + LANES), load(entries + 2 * LANES)};
}
WRY_INLINE Vec gather_vec(const double* field, const std::int32_t* nodes) {
  return {gather(field, nodes, 3, 0), gather(field, nodes, 3, 1), gather(field, nodes, 3, 2)};
}
WRY_INLINE Quat load_quat(const double* entries) {
  return {load(entries), load(entries + LANES), load(entries + 2 * LANES), load(entries + 3 * LANES)};
}
WRY_INLINE Quat gather_quat(const double* field, const std::int32_t* nodes) {
  return {gather(field, nodes, 4, 0), gather(field, nodes, 4, 1), gather(field, nodes, 4, 2),
          gather(field, nodes, 4, 3)};
}

} // namespace wry::fem::WRY_ISA
