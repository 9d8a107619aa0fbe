#pragma once

#include "sim/mpm/matter/kernels/step.h"

/// The maps of anisotropic matter as kernels apply them: on plain components, Mandel's factors folded in.
namespace wry::mpm::WRY_ISA {

/// A 6 x 6 map that mixes normal components with normal ones only and keeps each shear to itself. Entries are scalars
/// for all particles, or packs.
template <class E> struct BlockMap {
  E n[9]; ///< normal x normal, row-major
  E s[3]; ///< yz, zx, xy
};
template <class E, class P> WRY_INLINE Sym<P> apply(const BlockMap<E>& m, const Sym<P>& x) {
  return {m.n[0] * x.xx + m.n[1] * x.yy + m.n[2] * x.zz,
          m.n[3] * x.xx + m.n[4] * x.yy + m.n[5] * x.zz,
          m.n[6] * x.xx + m.n[7] * x.yy + m.n[8] * x.zz,
          m.s[0] * x.yz,
          m.s[1] * x.zx,
          m.s[2] * x.xy};
}
/// tr(m : .) as weights of plain components.
template <class E, class P> WRY_INLINE Sym<P> trace_row(const BlockMap<E>& m, P zero) {
  return {zero + (m.n[0] + m.n[3] + m.n[6]),
          zero + (m.n[1] + m.n[4] + m.n[7]),
          zero + (m.n[2] + m.n[5] + m.n[8]),
          zero,
          zero,
          zero};
}

/// Any 6 x 6 with minor symmetries, on plain components.
template <class T> struct FullMap { T m[36]; };
template <class T, class P> WRY_INLINE Sym<P> apply(const FullMap<T>& map, const Sym<P>& x) {
  const auto row = [&](int i) {
    const T* m = map.m + 6 * i;
    return m[0] * x.xx + m[1] * x.yy + m[2] * x.zz + m[3] * x.yz + m[4] * x.zx + m[5] * x.xy;
  };
  return {row(0), row(1), row(2), row(3), row(4), row(5)};
}
template <class T, class P> WRY_INLINE Sym<P> trace_row(const FullMap<T>& map, P zero) {
  const auto column = [&](int j) { return zero + (map.m[j] + map.m[6 + j] + map.m[12 + j]); };
  return {column(0), column(1), column(2), column(3), column(4), column(5)};
}

template <class T> WRY_INLINE BlockMap<T> block_map(const T* mandel) {
  BlockMap<T> map;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      map.n[3 * i + j] = mandel[6 * i + j];
    map.s[i] = mandel[6 * (i + 3) + i + 3];
  }
  return map;
}
template <class T> WRY_INLINE FullMap<T> full_map(const T* mandel) {
  constexpr T ROOT_2 = static_cast<T>(1.4142135623730950488);
  FullMap<T> map;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      const T entry = mandel[6 * i + j];
      map.m[6 * i + j] = i < 3 && j >= 3 ? entry * ROOT_2 : i >= 3 && j < 3 ? entry / ROOT_2 : entry;
    }
  }
  return map;
}

/// The four maps of a material.
template <class Map> struct MapSet { Map elasticity, strain, strain_inverse, stress_inverse; };

/// One set for all particles.
template <class T> struct SharedBlockMaps {
  static constexpr bool REORIENTS = false;
  MapSet<BlockMap<T>> maps;
  explicit SharedBlockMaps(const Constants<T>& material)
      : maps{block_map(material.elasticity), block_map(material.strain_map), block_map(material.strain_map_inverse),
             block_map(material.stress_map_inverse)} {}
};
template <class T> struct SharedFullMaps {
  static constexpr bool REORIENTS = false;
  MapSet<FullMap<T>> maps;
  explicit SharedFullMaps(const Constants<T>& material)
      : maps{full_map(material.elasticity), full_map(material.strain_map), full_map(material.strain_map_inverse),
             full_map(material.stress_map_inverse)} {}
};

/// What an axis has, from the share of grains that point along it: linear between the limits of spec S8.
template <class P> WRY_INLINE P between_limits(P lambda, const ScalarOf<P>* limits) {
  using T = ScalarOf<P>;
  const P below = limits[0] + (static_cast<T>(1) - static_cast<T>(3) * lambda) * (limits[2] - limits[0]);
  const P above =
      limits[0] + (static_cast<T>(0.5) * (static_cast<T>(3) * lambda - static_cast<T>(1))) * (limits[1] - limits[0]);
  return lambda < static_cast<T>(1.0 / 3.0) ? below : above;
}

/// The maps of grains with these second moments, a set per lane; the same algebra as interpolate_parameters() and
/// make_maps(). Cheaper to make again in every step than to read from memory.
template <class P>
WRY_INLINE MapSet<BlockMap<P>> maps_of(const Constants<ScalarOf<P>>& material, const Vec<P>& lambda) {
  using T = ScalarOf<P>;
  const P one = all_lanes<P>(1.0);
  const P l[3] = {lambda.x, lambda.y, lambda.z};
  P E[3], nu[3], a[3], d[3];
  for (int i = 0; i < 3; ++i) {
    E[i] = between_limits(l[i], material.axis_modulus);
    nu[i] = between_limits(l[i], material.axis_ratio);
    a[i] = between_limits(l[i], material.axis_scale);
    d[i] = root(E[i]);
  }
  const Sym<P> N = {one, one, one, -nu[0], -nu[1], -nu[2]};
  const Sym<P> adjugate_N = adjugate(N);
  const P inverse = one / determinant(N);
  const P C[9] = {adjugate_N.xx, adjugate_N.xy, adjugate_N.zx, adjugate_N.xy, adjugate_N.yy,
                  adjugate_N.yz, adjugate_N.zx, adjugate_N.yz, adjugate_N.zz};
  const P S[9] = {one, -nu[2], -nu[1], -nu[2], one, -nu[0], -nu[1], -nu[0], one};
  const P two_mu = P{} + static_cast<T>(2) * material.mu, fit_lambda = P{} + material.lambda;
  const P share = fit_lambda / (static_cast<T>(3) * fit_lambda + two_mu);
  MapSet<BlockMap<P>> maps;
  for (int j = 0; j < 3; ++j) {
    P total = P{};
    P stress[3];
    for (int i = 0; i < 3; ++i) {
      maps.elasticity.n[3 * i + j] = C[3 * i + j] * inverse * d[i] * d[j];
      stress[i] = a[i] * a[i] * maps.elasticity.n[3 * i + j];
      total = total + stress[i];
    }
    for (int i = 0; i < 3; ++i) {
      maps.strain.n[3 * i + j] = (stress[i] - share * total) / two_mu;
      maps.stress_inverse.n[3 * i + j] = i == j ? one / (a[i] * a[i]) : P{};
    }
  }
  for (int i = 0; i < 3; ++i) {
    P weights[3], total = P{};
    for (int k = 0; k < 3; ++k) {
      weights[k] = S[3 * i + k] / (d[i] * d[k] * a[k] * a[k]);
      total = total + weights[k];
    }
    for (int j = 0; j < 3; ++j)
      maps.strain_inverse.n[3 * i + j] = two_mu * weights[j] + fit_lambda * total;
    const int u = (i + 1) % 3, v = (i + 2) % 3;
    maps.elasticity.s[i] = d[u] * d[v] / (one + nu[i]);
    maps.stress_inverse.s[i] = one / (a[u] * a[v]);
    maps.strain.s[i] = a[u] * a[v] * maps.elasticity.s[i] / two_mu;
    maps.strain_inverse.s[i] = one / maps.strain.s[i];
  }
  return maps;
}

} // namespace wry::mpm::WRY_ISA
