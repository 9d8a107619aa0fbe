#include "sim/mpm/matter/kernels/frames.h"
#include "sim/mpm/matter/kernels/matter_kernels.h"

/// How stress answers a rate of strain while the frame and the stiffness stay as they are (spec S6, semi-implicit).
namespace wry::mpm::WRY_ISA {

namespace {

/// Calls visit(tile, lane) for every pack.
template <class T, class Visit> WRY_INLINE void for_packs(int tiles, const Visit& visit) {
  for (int tile = 0; tile < tiles; ++tile) {
    for (int lane = 0; lane < TILE_WIDTH<T>; lane += LANES_OF<Pack<T>>)
      visit(tile, lane);
  }
}

template <class P>
WRY_INLINE P frozen_factor(const Constants<ScalarOf<P>>& material, const ConstitutiveTiles<ScalarOf<P>>& tiles,
                           int tile, int lane) {
  const int at1 = place<ScalarOf<P>>(tile, 1, lane);
  Memory<P> memory{};
  memory.plastic_volume = load_or<P>(tiles.of(Channel::plastic_volume), at1, 1.0);
  return stiffness_factor(material, memory, load_or<P>(tiles.of(Channel::stiffness_scale), at1, 1.0));
}

template <class P> WRY_INLINE Vec<P> unit_vector(const Vec<P>& a) {
  return (all_lanes<P>(1.0) / root(dot(a, a))) * a;
}

/// Q as it is now: x and z suffice.
template <class P>
WRY_INLINE void freeze_frame(const Constants<ScalarOf<P>>& material, const ConstitutiveTiles<ScalarOf<P>>& tiles,
                             int tile, int lane, ScalarOf<P>* frozen) {
  using T = ScalarOf<P>;
  constexpr int STRIDE = TILE_WIDTH<T>;
  const Quat<P> stored = load_quaternion<P>(tiles.of(Channel::frame) + place<T>(tile, 4, lane), STRIDE);
  Mat<P> Q = rotation(stored);
  if (material.frame == FrameMode::polar)
    Q = nearest_rotation(load_matrix<P>(tiles.deformation + place<T>(tile, 9, lane), STRIDE)) * Q;
  const Mat<P> axes = transposed(Q);
  const Vec<P> z = unit_vector(axes.r2);
  const Vec<P> x = unit_vector(axes.r0 - dot(axes.r0, z) * z);
  const P values[FROZEN_AXES] = {x.x, x.y, x.z, z.x, z.y, z.z, frozen_factor<P>(material, tiles, tile, lane)};
  for (int i = 0; i < FROZEN_AXES; ++i)
    store_lanes<P>(frozen + i * STRIDE, values[i]);
}

template <class P> struct Frozen {
  Mat<P> Q;
  P factor;
};
template <class P> WRY_INLINE Frozen<P> load_frozen(const ScalarOf<P>* frozen) {
  constexpr int STRIDE = TILE_WIDTH<ScalarOf<P>>;
  const auto at = [frozen](int i) { return load_lanes<P>(frozen + i * STRIDE); };
  const Vec<P> x = {at(0), at(1), at(2)}, z = {at(3), at(4), at(5)};
  return {transposed(Mat<P>{x, cross(z, x), z}), at(6)};
}

/// sigma of one pack, by the elasticity that `elasticity(lane)` gives.
template <class T, class Elasticity>
WRY_INLINE void stress_in_axes(const T* frozen, T* rate, const Elasticity& elasticity) {
  using P = Pack<T>;
  for (int lane = 0; lane < TILE_WIDTH<T>; lane += LANES_OF<P>) {
    const Frozen<P> state = load_frozen<P>(frozen + lane);
    const Sym<P> D = congruent(transposed(state.Q), load_symmetric<P>(rate + lane, TILE_WIDTH<T>));
    const Sym<P> sigma = state.factor * congruent(state.Q, apply(elasticity(lane), D));
    store_symmetric<P>(rate + lane, TILE_WIDTH<T>, sigma);
  }
}

} // namespace

template <class T>
void freeze_isotropic(const MaterialConstants<T>& material, const ConstitutiveTiles<T>& tiles, T* frozen) {
  using P = Pack<T>;
  for_packs<T>(tiles.count, [&](int tile, int lane) {
    store_lanes<P>(frozen + place<T>(tile, FROZEN_FACTOR, lane), frozen_factor<P>(material, tiles, tile, lane));
  });
}

template <class T>
void freeze_axes(const MaterialConstants<T>& material, const ConstitutiveTiles<T>& tiles, T* frozen) {
  for_packs<T>(tiles.count, [&](int tile, int lane) {
    freeze_frame<Pack<T>>(material, tiles, tile, lane, frozen + place<T>(tile, FROZEN_AXES, lane));
  });
}

template <class T>
void freeze_grains(const MaterialConstants<T>& material, const ConstitutiveTiles<T>& tiles, T* frozen) {
  using P = Pack<T>;
  for_packs<T>(tiles.count, [&](int tile, int lane) {
    T* to = frozen + place<T>(tile, FROZEN_GRAINS, lane);
    freeze_frame<P>(material, tiles, tile, lane, to);
    const T* moment = tiles.of(Channel::second_moment) + place<T>(tile, 6, lane);
    for (int i = 0; i < 3; ++i)
      store_lanes<P>(to + (FROZEN_AXES + i) * TILE_WIDTH<T>, load_lanes<P>(moment + i * TILE_WIDTH<T>));
  });
}

template <class T> void tangent_isotropic(const MaterialConstants<T>& material, const T* frozen, T* rate) {
  using P = Pack<T>;
  const P two_mu = P{} + static_cast<T>(2) * material.mu;
  for (int lane = 0; lane < TILE_WIDTH<T>; lane += LANES_OF<P>) {
    const Sym<P> D = load_symmetric<P>(rate + lane, TILE_WIDTH<T>);
    const Sym<P> sigma = load_lanes<P>(frozen + lane) * plus_identity(two_mu * D, material.lambda * trace(D));
    store_symmetric<P>(rate + lane, TILE_WIDTH<T>, sigma);
  }
}

template <class T> void tangent_orthotropic(const MaterialConstants<T>& material, const T* frozen, T* rate) {
  const BlockMap<T> elasticity = block_map(material.elasticity);
  stress_in_axes<T>(frozen, rate, [&](int) { return elasticity; });
}

template <class T> void tangent_general(const MaterialConstants<T>& material, const T* frozen, T* rate) {
  const FullMap<T> elasticity = full_map(material.elasticity);
  stress_in_axes<T>(frozen, rate, [&](int) { return elasticity; });
}

template <class T> void tangent_reoriented(const MaterialConstants<T>& material, const T* frozen, T* rate) {
  using P = Pack<T>;
  stress_in_axes<T>(frozen, rate, [&](int lane) {
    const auto share = [&](int i) { return load_lanes<P>(frozen + (FROZEN_AXES + i) * TILE_WIDTH<T> + lane); };
    return maps_of(material, Vec<P>{share(0), share(1), share(2)}).elasticity;
  });
}

WRY_MATTER_KERNELS_TANGENT(template)

} // namespace wry::mpm::WRY_ISA
