#pragma once

#include "sim/mpm/matter/kernels/maps.h"

/// How a lane's frame turns, and its grains in it (spec S7, S8).
namespace wry::mpm::WRY_ISA {

/// Q <- polar(I + dt C) Q: shape matching on quadratic B-splines.
template <class P>
WRY_INLINE Quat<P> matched_frame(const ConstitutiveTiles<ScalarOf<P>>& tiles, int tile, int lane, const Quat<P>& Q) {
  using T = ScalarOf<P>;
  const Mat<P> C = load_matrix<P>(tiles.affine + place<T>(tile, 9, lane), TILE_WIDTH<T>);
  const P dt = P{} + tiles.dt, one = all_lanes<P>(1.0);
  Mat<P> A = {dt * C.r0, dt * C.r1, dt * C.r2};
  A.r0.x = A.r0.x + one;
  A.r1.y = A.r1.y + one;
  A.r2.z = A.r2.z + one;
  return unit(quaternion_of(nearest_rotation(A)) * Q);
}

/// One rotation of the cyclic Jacobi of Pi: at most 45 degrees, none across a gap below 1e-3.
template <class P> WRY_INLINE bool turn_pair(P& a, P& b, P& r, P& p, P& q, Vec<P>& n_p, Vec<P>& n_q) {
  constexpr ScalarOf<P> GAP = static_cast<ScalarOf<P>>(1e-3), TINY = LaneTraits<P>::EPSILON / 16;
  const P twice = r + r, d = a - b;
  const MaskOf<P> skip = (d * d + twice * twice < GAP * GAP) | (magnitude(r) < TINY);
  return annihilate(a, b, r, p, q, n_p, n_q, skip);
}

/// Evolves the second moment of the grains by the flow and turns the frame so that it stays diagonal. `Q` is the frame
/// after the flow's own rotation; `stored` is what the channel holds and is turned alike.
template <class P>
WRY_INLINE Sym<P> reorient_grains(const Constants<ScalarOf<P>>& material, const ConstitutiveTiles<ScalarOf<P>>& tiles,
                                  int tile, int lane, Mat<P>& Q, Quat<P>& stored) {
  using T = ScalarOf<P>;
  constexpr int STRIDE = TILE_WIDTH<T>;
  T* channel = tiles.of(Channel::second_moment) + place<T>(tile, 6, lane);
  const Mat<P> L = load_matrix<P>(tiles.velocity_gradient + place<T>(tile, 9, lane), STRIDE);
  const P quarter = all_lanes<P>(-0.125) * tiles.dt; // -1/4 dt times half the differences of L
  const Quat<P> back = unit(Quat<P>{all_lanes<P>(1.0), quarter * (L.r2.y - L.r1.z), quarter * (L.r0.z - L.r2.x),
                                    quarter * (L.r1.x - L.r0.y)});
  const Mat<P> middle = rotation(back) * Q;
  const Sym<P> D = congruent(transposed(middle), symmetric_part(L));
  const Mat<P> B = as_matrix(exponential_series((P{} + tiles.dt * material.jeffery) * D));
  Sym<P> Pi = congruent(B, load_symmetric<P>(channel, STRIDE));
  Pi = (all_lanes<P>(1.0) / trace(Pi)) * Pi;
  const P one = all_lanes<P>(1.0), zero = P{};
  Mat<P> turn = {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}}; // its rows are the new axes
  for (int sweep = 0; sweep < 8; ++sweep) {
    bool moved = turn_pair(Pi.xx, Pi.yy, Pi.xy, Pi.zx, Pi.yz, turn.r0, turn.r1);
    moved |= turn_pair(Pi.xx, Pi.zz, Pi.zx, Pi.xy, Pi.yz, turn.r0, turn.r2);
    moved |= turn_pair(Pi.yy, Pi.zz, Pi.yz, Pi.xy, Pi.zx, turn.r1, turn.r2);
    if (!moved)
      break;
  }
  const Mat<P> columns = transposed(turn);
  Q = Q * columns;
  stored = unit(stored * quaternion_of(columns));
  store_symmetric<P>(channel, STRIDE, Pi);
  return Pi;
}

} // namespace wry::mpm::WRY_ISA
