#pragma once

#include "sim/mpm/matter/kernels/return_maps.h"

/// What the kernels of isotropic and anisotropic matter share: the way through the tiles.
namespace wry::mpm::WRY_ISA {

template <class T> using Constants = MaterialConstants<T>;

/// One pack of particles.
template <class P> struct Trial {
  Mat<P> F;         ///< F_trial
  Memory<P> memory; ///< in and out
  P scale;          ///< on all moduli
};
template <class P> struct Outcome {
  Mat<P> F;
  Sym<P> kirchhoff;
};

template <class P> WRY_INLINE P load_or(const ScalarOf<P>* channel, int offset, double otherwise) {
  return channel != nullptr ? load_lanes<P>(channel + offset) : all_lanes<P>(otherwise);
}
template <class P> WRY_INLINE void store_if(ScalarOf<P>* channel, int offset, P value) {
  if (channel != nullptr)
    store_lanes<P>(channel + offset, value);
}

/// Where the pack at `lane` of `tile` has component 0 of a channel.
template <class T> WRY_INLINE int place(int tile, int components, int lane) {
  return tile * components * TILE_WIDTH<T> + lane;
}

template <class P> WRY_INLINE int first_lane_of(MaskOf<P> mask) {
  for (int i = 0; i < LANES_OF<P>; ++i) {
    if (mask[i] != 0)
      return i;
  }
  return -1;
}

template <class P>
WRY_INLINE Trial<P> load_trial(const ConstitutiveTiles<ScalarOf<P>>& tiles, int tile, int lane, MaskOf<P>& failed) {
  using T = ScalarOf<P>;
  constexpr int STRIDE = TILE_WIDTH<T>;
  const int at9 = place<T>(tile, 9, lane), at1 = place<T>(tile, 1, lane);
  const Mat<P> L = load_matrix<P>(tiles.velocity_gradient + at9, STRIDE);
  const P dt = P{} + tiles.dt, one = all_lanes<P>(1.0);
  Mat<P> step = {dt * L.r0, dt * L.r1, dt * L.r2};
  step.r0.x = step.r0.x + one;
  step.r1.y = step.r1.y + one;
  step.r2.z = step.r2.z + one;
  Trial<P> trial;
  trial.F = step * load_matrix<P>(tiles.deformation + at9, STRIDE);
  failed = ~((determinant(step) > 0) & (determinant(trial.F) > 0));
  trial.memory.hardening = load_or<P>(tiles.of(Channel::hardening), at1, 0.0);
  trial.memory.plastic_volume = load_or<P>(tiles.of(Channel::plastic_volume), at1, 1.0);
  trial.memory.volume_correction = load_or<P>(tiles.of(Channel::volume_correction), at1, 0.0);
  trial.memory.strength = load_or<P>(tiles.of(Channel::strength_scale), at1, 1.0);
  trial.scale = load_or<P>(tiles.of(Channel::stiffness_scale), at1, 1.0);
  return trial;
}

template <class P>
WRY_INLINE void store_outcome(const ConstitutiveTiles<ScalarOf<P>>& tiles, int tile, int lane, const Trial<P>& trial,
                              const Outcome<P>& outcome) {
  using T = ScalarOf<P>;
  constexpr int STRIDE = TILE_WIDTH<T>;
  const int at1 = place<T>(tile, 1, lane);
  store_matrix<P>(tiles.deformation + place<T>(tile, 9, lane), STRIDE, outcome.F);
  store_symmetric<P>(tiles.stress + place<T>(tile, 6, lane), STRIDE, outcome.kirchhoff);
  store_if<P>(tiles.of(Channel::hardening), at1, trial.memory.hardening);
  store_if<P>(tiles.of(Channel::plastic_volume), at1, trial.memory.plastic_volume);
  store_if<P>(tiles.of(Channel::volume_correction), at1, trial.memory.volume_correction);
}

/// Stresses that are numbers: their sum is below infinity in size, which no NaN is.
template <class P> WRY_INLINE MaskOf<P> is_finite(const Sym<P>& s) {
  const P total =
      magnitude(s.xx) + magnitude(s.yy) + magnitude(s.zz) + magnitude(s.yz) + magnitude(s.zx) + magnitude(s.xy);
  return total <= all_lanes<P>(sizeof(ScalarOf<P>) == 4 ? 3e38 : 1.7e308);
}

template <class P>
WRY_INLINE void note_stiffness(const Constants<ScalarOf<P>>& material, const Trial<P>& trial,
                               ConstitutiveReport& report) {
  if (material.plasticity != Plasticity::snow)
    return;
  const P factor = stiffness_factor(material, trial.memory, all_lanes<P>(1.0));
  for (int i = 0; i < LANES_OF<P>; ++i)
    report.stiffness_factor = factor[i] > report.stiffness_factor ? factor[i] : report.stiffness_factor;
}

/// Runs `advance(trial, tile, lane)` over every pack of the tiles.
template <class P, class Advance>
WRY_INLINE ConstitutiveReport over_tiles(const Constants<ScalarOf<P>>& material,
                                         const ConstitutiveTiles<ScalarOf<P>>& tiles, const Advance& advance) {
  using T = ScalarOf<P>;
  ConstitutiveReport report;
  for (int tile = 0; tile < tiles.count; ++tile) {
    for (int lane = 0; lane < TILE_WIDTH<T>; lane += LANES_OF<P>) {
      MaskOf<P> failed;
      Trial<P> trial = load_trial<P>(tiles, tile, lane, failed);
      const Outcome<P> outcome = advance(trial, tile, lane);
      failed = failed | ~is_finite(outcome.kirchhoff);
      store_outcome(tiles, tile, lane, trial, outcome);
      note_stiffness(material, trial, report);
      if (report.failed_lane < 0 && any_lane(failed))
        report.failed_lane = tile * TILE_WIDTH<T> + lane + first_lane_of<P>(failed);
    }
  }
  return report;
}

/// v_c of Tampubolon et al.: what the volume has grown without a right to.
template <class P> WRY_INLINE P next_correction(P before, P trial_trace, P elastic_trace) {
  return larger(before + trial_trace - elastic_trace, P{});
}

} // namespace wry::mpm::WRY_ISA
