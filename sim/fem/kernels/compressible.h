#pragma once

#include "sim/fem/kernels/element.h"

/// Energies shear/2 (tr F^T F - 3) + phi(J) with a barrier phi: +infinity for J <= 0. A law is a type with
///   static Real shear(const Element&)                 the shear modulus
///   static Real energy(const Element&, const Volume&)  the density, free of cancellation near F = I
///   static VolumeSlopes slopes(const Element&, Real J) phi' and phi''
namespace wry::fem::WRY_ISA {

/// What energies need of F: G = F^T F - I, its invariants, and logarithms that are exact for small strains.
struct Volume {
  Real J;              ///< 1 where det F is not positive
  Real trace;          ///< tr G
  Real trace_minus_ln; ///< tr G - ln det(I + G)
  Real j_minus_ln;     ///< J^2 - 1 - ln J^2
  Real ln_J;
};

/// phi'(J) and phi''(J)
struct VolumeSlopes {
  Real first, second;
};

WRY_INLINE Volume measure_volume(const Element& element, Real J) {
  const Mat F = deformation_gradient(element);
  const Mat Ft = transposed(F);
  const Real xx = dot(Ft.r0, Ft.r0) - 1.0, yy = dot(Ft.r1, Ft.r1) - 1.0, zz = dot(Ft.r2, Ft.r2) - 1.0;
  const Real xy = dot(Ft.r0, Ft.r1), xz = dot(Ft.r0, Ft.r2), yz = dot(Ft.r1, Ft.r2);
  const Real tr = xx + yy + zz;
  const Real second = xx * yy + yy * zz + zz * xx - xy * xy - xz * xz - yz * yz;
  const Real det = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  // Near J = 1 the logarithm starts from J^2 - 1 = tr G + second + det, which keeps the digits that J^2 has lost.
  const Real j = tr + second + det;
  LogParts parts = split_for_log(J * J);
  const auto near = parts.exponent == 0.0;
  parts.f = near ? j : parts.f;
  const Real defect = log_defect(parts.f);
  const Real ln = log_of_parts(parts, defect);
  Volume volume;
  volume.J = J;
  volume.trace = tr;
  volume.trace_minus_ln = near ? defect - second - det : tr - ln;
  volume.j_minus_ln = near ? defect : J * J - 1.0 - ln;
  volume.ln_J = 0.5 * ln;
  return volume;
}

/// Adds V (shear/2 (tr F^T F - 3) + phi(J)) of the law to the part.
template <class Law, Order ORDER> WRY_INLINE void add_compressible(const Element& element, PositionPart& part) {
  const Vec* e = element.edges;
  const Vec* g = element.gradients;
  const Vec area[3] = {cross(e[1], e[2]), cross(e[2], e[0]), cross(e[0], e[1])};
  const Real density = dot(cross(g[0], g[1]), g[2]); // det of the shape gradients
  const Real det = dot(e[0], area[0]) * density;
  const auto valid = det > 0.0;
  const Real J = valid ? det : broadcast(1.0);
  const auto real_element = element.volume > 0.0;
  const Real energy =
      valid ? element.volume * Law::energy(element, measure_volume(element, J)) : broadcast(__builtin_inf());
  part.energy += real_element ? energy : Real{};
  if constexpr (ORDER == Order::energy)
    return;

  const VolumeSlopes slopes = Law::slopes(element, J);
  const Real slope = element.volume * slopes.first * density;
  const Real shear = element.volume * Law::shear(element);
  const Real g00 = dot(g[0], g[0]), g01 = dot(g[0], g[1]), g02 = dot(g[0], g[2]);
  const Real g11 = dot(g[1], g[1]), g12 = dot(g[1], g[2]), g22 = dot(g[2], g[2]);
  part.force[0] = part.force[0] + shear * (g00 * e[0] + g01 * e[1] + g02 * e[2]) + slope * area[0];
  part.force[1] = part.force[1] + shear * (g01 * e[0] + g11 * e[1] + g12 * e[2]) + slope * area[1];
  part.force[2] = part.force[2] + shear * (g02 * e[0] + g12 * e[1] + g22 * e[2]) + slope * area[2];
  if constexpr (ORDER == Order::gradient)
    return;

  // d2E/dx_k dx_l = shear g_kl I + phi'' h_k h_l^T + phi' dh_k/dx_l, where h_k = cof(F) g_k is an area of the deformed
  // tet.
  const Real bend = element.volume * slopes.second * density * density;
  const auto block = [&](const Vec& k, const Vec& l, Real metric) {
    return plus_identity(outer(bend * k, l), shear * metric);
  };
  part.blocks[0] = part.blocks[0] + block(area[0], area[0], g00);
  part.blocks[1] = part.blocks[1] + minus_cross(block(area[0], area[1], g01), slope * e[2]);
  part.blocks[2] = part.blocks[2] + plus_cross(block(area[0], area[2], g02), slope * e[1]);
  part.blocks[3] = part.blocks[3] + block(area[1], area[1], g11);
  part.blocks[4] = part.blocks[4] + minus_cross(block(area[1], area[2], g12), slope * e[0]);
  part.blocks[5] = part.blocks[5] + block(area[2], area[2], g22);
}

/// mu/2 (I_C - 3) - mu ln J + lambda/2 ln^2 J
struct LogLaw {
  WRY_INLINE static Real shear(const Element& element) { return element.mu; }
  WRY_INLINE static Real energy(const Element& element, const Volume& volume) {
    return 0.5 * (element.mu * volume.trace_minus_ln + element.lambda * volume.ln_J * volume.ln_J);
  }
  WRY_INLINE static VolumeSlopes slopes(const Element& element, Real J) {
    const Real inverse = 1.0 / J;
    const Real pressure = element.lambda * log(J) - element.mu;
    return {pressure * inverse, (element.lambda - pressure) * inverse * inverse};
  }
};

/// The paper's eq 16 without couple modulus: mu/2 (I_C - 3) + lambda/4 (J^2 - 1) - (lambda/2 + mu) ln J
struct SquareLogLaw {
  WRY_INLINE static Real shear(const Element& element) { return element.mu; }
  WRY_INLINE static Real energy(const Element& element, const Volume& volume) {
    return 0.5 * element.mu * volume.trace_minus_ln + 0.25 * element.lambda * volume.j_minus_ln;
  }
  WRY_INLINE static VolumeSlopes slopes(const Element& element, Real J) {
    const Real inverse = 1.0 / J;
    const Real half = 0.5 * element.lambda;
    const Real barrier = (half + element.mu) * inverse;
    return {half * J - barrier, half + barrier * inverse};
  }
};

/// The determinant's volume term of micropolar models: lambda/4 ((J - 1)^2 + (1/J - 1)^2)
struct ReciprocalLaw {
  WRY_INLINE static Real shear(const Element&) { return Real{}; }
  WRY_INLINE static Real energy(const Element& element, const Volume& volume) {
    const Real growth = volume.J - 1.0;
    const Real shrinkage = growth / volume.J;
    return 0.25 * element.lambda * (growth * growth + shrinkage * shrinkage);
  }
  WRY_INLINE static VolumeSlopes slopes(const Element& element, Real J) {
    const Real inverse = 1.0 / J;
    const Real half = 0.5 * element.lambda;
    const Real square = inverse * inverse;
    const Real growth = J - 1.0;
    return {half * growth * (1.0 + square * inverse), half * (1.0 + square * inverse * (3.0 * inverse - 2.0))};
  }
};

} // namespace wry::fem::WRY_ISA
