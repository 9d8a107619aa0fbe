#include "sim/mpm/matter/kernels/frames.h"
#include "sim/mpm/matter/kernels/matter_kernels.h"

/// Matter with axes (spec S4): local strain, fictitious strain, return map, and the way back.
namespace wry::mpm::WRY_ISA {

namespace {

template <class P> struct Polar {
  Sym<P> strain; ///< f(V), world
  Mat<P> rotation;
};

template <class P> [[gnu::noinline]] Polar<P> spectral_polar(StrainMeasure measure, const Mat<P>& F) {
  const LeftSvd<P> svd = left_svd(F);
  return {spectral(svd.axes, strains_of(measure, svd.stretches)), svd.axes * svd.unit_rows};
}

template <class P> WRY_INLINE MaskOf<P> is_small(const Sym<P>& strain) {
  using T = ScalarOf<P>;
  const Sym<P> deviator = plus_identity(strain, trace(strain) * static_cast<T>(-1.0 / 3.0));
  return contracted(deviator, deviator) < static_cast<T>(SERIES_LIMIT * SERIES_LIMIT);
}

template <class P> WRY_INLINE Polar<P> polar(StrainMeasure measure, const Mat<P>& F) {
  if (measure == StrainMeasure::biot)
    return spectral_polar(measure, F);
  Polar<P> result;
  result.strain = log_stretch_series(F);
  const P minus = all_lanes<P>(-1.0);
  result.rotation = as_matrix(exponential_series(minus * result.strain)) * F;
  const MaskOf<P> good = is_small(result.strain);
  if (any_lane(~good)) {
    const Polar<P> exact = spectral_polar(measure, F);
    result.strain = choose(good, result.strain, exact.strain);
    result.rotation = choose(good, result.rotation, exact.rotation);
  }
  return result;
}

/// The elastic state of a lane in its own axes.
template <class P> struct Local {
  Sym<P> stretch; ///< V
  Sym<P> stress;  ///< tau
};

/// V and the conjugate stress by the axes of the strain.
template <class P>
[[gnu::noinline]] Local<P> spectral_local(StrainMeasure measure, const Sym<P>& strain, const Sym<P>& T) {
  using S = ScalarOf<P>;
  const P one = all_lanes<P>(1.0);
  Eigen3<P> eigen = symmetric_eigen(strain);
  if (measure == StrainMeasure::biot) {
    const P least = all_lanes<P>(0.05 - 1.0);
    eigen.values = {larger(eigen.values.x, least), larger(eigen.values.y, least), larger(eigen.values.z, least)};
  }
  const Vec<P> s = stretches_of(measure, eigen.values);
  const auto weight = [&](P ea, P eb, P sa, P sb) {
    if (measure == StrainMeasure::biot)
      return static_cast<S>(2) * sa * sb / (sa + sb);
    const P x = ea - eb, ratio = sa / sb; // x / sinh x = 2 x / (e^x - e^-x)
    const P series = one - x * x * static_cast<S>(1.0 / 6.0) + x * x * x * x * static_cast<S>(7.0 / 360.0);
    constexpr S SMALL = sizeof(S) == 4 ? static_cast<S>(0.1) : static_cast<S>(2e-3);
    return magnitude(x) < SMALL ? series : static_cast<S>(2) * x / (ratio - one / ratio);
  };
  const Vec<P>& e = eigen.values;
  Sym<P> t = congruent(transposed(eigen.axes), T);
  if (measure == StrainMeasure::biot) {
    t.xx = t.xx * s.x;
    t.yy = t.yy * s.y;
    t.zz = t.zz * s.z;
  }
  t.yz = t.yz * weight(e.y, e.z, s.y, s.z);
  t.zx = t.zx * weight(e.z, e.x, s.z, s.x);
  t.xy = t.xy * weight(e.x, e.y, s.x, s.y);
  return {spectral(eigen.axes, s), congruent(eigen.axes, t)};
}

/// [E, [E, T]]
template <class P> WRY_INLINE Sym<P> double_commutator(const Sym<P>& E, const Sym<P>& T) {
  const P yz = E.xy * T.zx + E.yy * T.yz + E.yz * T.zz - T.xy * E.zx - T.yy * E.yz - T.yz * E.zz;
  const P zx = E.zx * T.xx + E.yz * T.xy + E.zz * T.zx - T.zx * E.xx - T.yz * E.xy - T.zz * E.zx;
  const P xy = E.xx * T.xy + E.xy * T.yy + E.zx * T.yz - T.xx * E.xy - T.xy * E.yy - T.zx * E.yz;
  const P mxx = E.zx * zx - E.xy * xy, myy = E.xy * xy - E.yz * yz, mzz = E.yz * yz - E.zx * zx;
  return {mxx + mxx,
          myy + myy,
          mzz + mzz,
          E.yy * yz - E.xy * zx + E.zx * xy - E.zz * yz,
          E.zz * zx - E.yz * xy + E.xy * yz - E.xx * zx,
          E.xx * xy - E.zx * yz + E.yz * zx - E.yy * xy};
}

/// x / sinh x of the differences of principal strains, as a series of commutators.
template <class P> WRY_INLINE Sym<P> conjugate_series(const Sym<P>& E, const Sym<P>& T) {
  using S = ScalarOf<P>;
  constexpr double WEIGHTS[] = {-1.0 / 6.0, 7.0 / 360.0, -31.0 / 15120.0, 127.0 / 604800.0, -73.0 / 3421440.0};
  constexpr int TERMS = sizeof(S) == 4 ? 3 : 5;
  Sym<P> term = T, total = T;
  for (int k = 0; k < TERMS; ++k) {
    term = double_commutator(E, term);
    total = total + all_lanes<P>(WEIGHTS[k]) * term;
  }
  return total;
}

template <class P>
WRY_INLINE Local<P> local_state(StrainMeasure measure, const Sym<P>& strain, const Sym<P>& T, bool flows) {
  if (measure == StrainMeasure::biot)
    return spectral_local(measure, strain, T);
  Local<P> local = {strain, conjugate_series(strain, T)};
  if (flows)
    local.stretch = exponential_series(strain);
  const MaskOf<P> good = is_small(strain);
  if (any_lane(~good)) {
    const Local<P> exact = spectral_local(measure, strain, T);
    local.stretch = choose(good, local.stretch, exact.stretch);
    local.stress = choose(good, local.stress, exact.stress);
  }
  return local;
}

template <class P> struct Fictitious {
  Sym<P> strain, stress;
  MaskOf<P> moved;
};

/// The isotropic solid's answer: return map and stress.
template <class P, class Map>
WRY_INLINE Fictitious<P> fictitious_state(const Constants<ScalarOf<P>>& material, const MapSet<Map>& maps,
                                          const Sym<P>& trial_strain, Memory<P>& memory) {
  using T = ScalarOf<P>;
  const P two_mu = P{} + static_cast<T>(2) * material.mu;
  Fictitious<P> state = {trial_strain, trial_strain, MaskOf<P>{}};
  const bool by_axes = material.plasticity == Plasticity::snow || material.plasticity == Plasticity::shear;
  if (material.plasticity == Plasticity::drucker_prager) {
    const Sym<P> row = trace_row(maps.strain_inverse, P{});
    state.moved =
        return_drucker_prager<P>(material, state.strain, memory, material.flow == Flow::isochoric ? &row : nullptr);
  }
  if (by_axes || material.elasticity_law == Elasticity::fixed_corotated) {
    Eigen3<P> eigen = symmetric_eigen(state.strain);
    if (by_axes) {
      state.moved = return_principal(material, eigen.values, memory);
      state.strain = choose(state.moved, spectral(eigen.axes, eigen.values), state.strain);
    }
    if (material.elasticity_law == Elasticity::fixed_corotated) {
      state.stress = spectral(eigen.axes, fixed_corotated_stress(material, eigen.values));
      return state;
    }
  }
  state.stress = plus_identity(two_mu * state.strain, material.lambda * trace(state.strain));
  return state;
}

/// From the trial state in the material's axes to the elastic one and its stress.
template <class P, class Map>
WRY_INLINE Outcome<P> finish(const Constants<ScalarOf<P>>& material, const MapSet<Map>& maps, const Polar<P>& world,
                             const Mat<P>& Q, Trial<P>& trial) {
  const Sym<P> strain = congruent(transposed(Q), world.strain);
  Sym<P> elastic = strain, stress;
  MaskOf<P> moved = MaskOf<P>{};
  if (material.uses_maps) {
    if (material.corrects_volume) {
      elastic = plus_identity(elastic, trial.memory.volume_correction * static_cast<ScalarOf<P>>(1.0 / 3.0));
      moved = trial.memory.volume_correction != 0;
    }
    const Sym<P> before = apply(maps.strain, elastic);
    const Fictitious<P> state = fictitious_state(material, maps, before, trial.memory);
    moved = moved | state.moved;
    elastic = choose(state.moved, elastic + apply(maps.strain_inverse, state.strain - before), elastic);
    stress = apply(maps.stress_inverse, state.stress);
    if (material.corrects_volume)
      trial.memory.volume_correction = next_correction(trial.memory.volume_correction, trace(strain), trace(elastic));
  } else {
    stress = apply(maps.elasticity, elastic);
  }
  const bool flows = any_lane(moved);
  const Local<P> local = local_state(material.measure, elastic, stress, flows);
  Outcome<P> outcome;
  outcome.F = trial.F;
  if (flows)
    outcome.F = choose(moved, as_matrix(congruent(Q, local.stretch)) * world.rotation, trial.F);
  outcome.kirchhoff = stiffness_factor(material, trial.memory, trial.scale) * congruent(Q, local.stress);
  return outcome;
}

/// Shared maps, or those of each lane's grains.
template <class T, class Maps>
WRY_INLINE ConstitutiveReport update(const Constants<T>& material, const ConstitutiveTiles<T>& tiles,
                                     const Maps& shared) {
  using P = Pack<T>;
  return over_tiles<P>(material, tiles, [&](Trial<P>& trial, int tile, int lane) {
    const Polar<P> world = polar(material.measure, trial.F);
    T* channel = tiles.of(Channel::frame) + place<T>(tile, 4, lane);
    Quat<P> stored = load_quaternion<P>(channel, TILE_WIDTH<T>);
    if (material.frame == FrameMode::shape) {
      stored = matched_frame<P>(tiles, tile, lane, stored);
      store_quaternion<P>(channel, TILE_WIDTH<T>, stored);
    }
    Mat<P> Q = rotation(stored);
    if (material.frame == FrameMode::polar)
      Q = world.rotation * Q;
    if constexpr (Maps::REORIENTS) {
      const Sym<P> Pi = reorient_grains(material, tiles, tile, lane, Q, stored);
      store_quaternion<P>(channel, TILE_WIDTH<T>, stored);
      return finish(material, maps_of(material, Vec<P>{Pi.xx, Pi.yy, Pi.zz}), world, Q, trial);
    } else {
      return finish(material, shared.maps, world, Q, trial);
    }
  });
}

struct GrainMaps {
  static constexpr bool REORIENTS = true;
};

} // namespace

template <class T>
ConstitutiveReport update_orthotropic(const MaterialConstants<T>& material, const ConstitutiveTiles<T>& tiles) {
  return update(material, tiles, SharedBlockMaps<T>(material));
}

template <class T>
ConstitutiveReport update_general(const MaterialConstants<T>& material, const ConstitutiveTiles<T>& tiles) {
  return update(material, tiles, SharedFullMaps<T>(material));
}

template <class T>
ConstitutiveReport update_reoriented(const MaterialConstants<T>& material, const ConstitutiveTiles<T>& tiles) {
  return update(material, tiles, GrainMaps{});
}

namespace {

template <class P, class Map>
WRY_INLINE P energy_density(const Constants<ScalarOf<P>>& material, const MapSet<Map>& maps, const Sym<P>& strain) {
  const P half = all_lanes<P>(0.5), one = all_lanes<P>(1.0);
  if (material.elasticity_law != Elasticity::fixed_corotated)
    return half * contracted(strain, apply(maps.elasticity, strain));
  const Vec<P> s = stretches_of(material.measure, symmetric_eigen(apply(maps.strain, strain)).values);
  const Vec<P> d = {s.x - one, s.y - one, s.z - one};
  const P volume = s.x * s.y * s.z - one;
  return material.mu * dot(d, d) + half * material.lambda * volume * volume;
}

} // namespace

template <class T>
void energy_anisotropic(const MaterialConstants<T>& material, const ConstitutiveTiles<T>& tiles, T* energy) {
  using P = Pack<T>;
  const SharedFullMaps<T> shared(material);
  for (int tile = 0; tile < tiles.count; ++tile) {
    for (int lane = 0; lane < TILE_WIDTH<T>; lane += LANES_OF<P>) {
      const int at1 = place<T>(tile, 1, lane);
      const Mat<P> F = load_matrix<P>(tiles.deformation + place<T>(tile, 9, lane), TILE_WIDTH<T>);
      const Polar<P> world = spectral_polar(material.measure, F);
      Mat<P> Q = rotation(load_quaternion<P>(tiles.of(Channel::frame) + place<T>(tile, 4, lane), TILE_WIDTH<T>));
      if (material.frame == FrameMode::polar)
        Q = world.rotation * Q;
      const Sym<P> strain = congruent(transposed(Q), world.strain);
      P density;
      if (material.reorients) {
        const Sym<P> Pi = load_symmetric<P>(tiles.of(Channel::second_moment) + place<T>(tile, 6, lane), TILE_WIDTH<T>);
        density = energy_density(material, maps_of(material, Vec<P>{Pi.xx, Pi.yy, Pi.zz}), strain);
      } else {
        density = energy_density(material, shared.maps, strain);
      }
      Memory<P> memory{};
      memory.plastic_volume = load_or<P>(tiles.of(Channel::plastic_volume), at1, 1.0);
      const P scale = load_or<P>(tiles.of(Channel::stiffness_scale), at1, 1.0);
      store_lanes<P>(energy + at1, density * stiffness_factor(material, memory, scale));
    }
  }
}

WRY_MATTER_KERNELS_ANISOTROPIC(template)

} // namespace wry::mpm::WRY_ISA
