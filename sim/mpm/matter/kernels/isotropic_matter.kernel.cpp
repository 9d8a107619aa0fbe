#include "sim/mpm/matter/kernels/matter_kernels.h"
#include "sim/mpm/matter/kernels/step.h"

/// Matter without axes: strain, stress and flow share the principal axes of V, so that no map, frame or conjugate
/// weight is needed.
namespace wry::mpm::WRY_ISA {

namespace {

/// Any law, by the principal stretches.
template <class P> [[gnu::noinline]] Outcome<P> spectral_step(const Constants<ScalarOf<P>>& material, Trial<P>& trial) {
  using T = ScalarOf<P>;
  const LeftSvd<P> svd = left_svd(trial.F);
  Vec<P> e = strains_of(material.measure, svd.stretches);
  const P before = sum(e), third = all_lanes<P>(1.0 / 3.0);
  MaskOf<P> moved = MaskOf<P>{};
  if (material.corrects_volume) {
    const P shift = third * trial.memory.volume_correction;
    e = {e.x + shift, e.y + shift, e.z + shift};
    moved = trial.memory.volume_correction != 0;
  }
  if (material.plasticity == Plasticity::drucker_prager) {
    Sym<P> strain = {e.x, e.y, e.z, P{}, P{}, P{}};
    moved = moved | return_drucker_prager<P>(material, strain, trial.memory, nullptr);
    e = {strain.xx, strain.yy, strain.zz};
  } else if (material.plasticity != Plasticity::none) {
    moved = moved | return_principal(material, e, trial.memory);
  }
  if (material.corrects_volume)
    trial.memory.volume_correction = next_correction(trial.memory.volume_correction, before, sum(e));
  if (material.measure == StrainMeasure::biot) {
    const P least = all_lanes<P>(0.05 - 1.0);
    e = {larger(e.x, least), larger(e.y, least), larger(e.z, least)};
  }
  const Vec<P> s = stretches_of(material.measure, e);
  const P lambda_trace = material.lambda * sum(e), two_mu = P{} + static_cast<T>(2) * material.mu;
  Vec<P> stress = {two_mu * e.x + lambda_trace, two_mu * e.y + lambda_trace, two_mu * e.z + lambda_trace};
  if (material.elasticity_law == Elasticity::fixed_corotated)
    stress = fixed_corotated_stress(material, e);
  if (material.measure == StrainMeasure::biot)
    stress = {stress.x * s.x, stress.y * s.y, stress.z * s.z};
  const P factor = stiffness_factor(material, trial.memory, trial.scale);
  Outcome<P> outcome;
  outcome.kirchhoff = factor * spectral(svd.axes, stress);
  const Mat<P> rows = {s.x * svd.unit_rows.r0, s.y * svd.unit_rows.r1, s.z * svd.unit_rows.r2};
  outcome.F = choose(moved, svd.axes * rows, trial.F);
  return outcome;
}

/// Hencky's law, alone or with Drucker-Prager, of lanes whose strain is small: no axes at all. `good` tells which.
template <class P>
WRY_INLINE Outcome<P> series_step(const Constants<ScalarOf<P>>& material, Trial<P>& trial, MaskOf<P>& good) {
  using T = ScalarOf<P>;
  const Sym<P> strain = log_stretch_series(trial.F);
  const P tr = trace(strain), third = all_lanes<P>(1.0 / 3.0);
  const Sym<P> deviator = plus_identity(strain, -third * tr);
  constexpr T LIMIT = static_cast<T>(SERIES_LIMIT * SERIES_LIMIT);
  good = contracted(deviator, deviator) < LIMIT;
  Outcome<P> outcome;
  outcome.F = trial.F;
  Sym<P> elastic = strain;
  if (material.plasticity == Plasticity::drucker_prager) {
    MaskOf<P> moved = MaskOf<P>{};
    if (material.corrects_volume) {
      elastic = plus_identity(elastic, third * trial.memory.volume_correction);
      moved = trial.memory.volume_correction != 0;
    }
    moved = moved | return_drucker_prager<P>(material, elastic, trial.memory, nullptr);
    if (material.corrects_volume)
      trial.memory.volume_correction = next_correction(trial.memory.volume_correction, tr, trace(elastic));
    if (any_lane(moved))
      outcome.F = choose(moved, as_matrix(exponential_series(elastic - strain)) * trial.F, trial.F);
  }
  const P pressure = material.lambda * trace(elastic);
  outcome.kirchhoff = trial.scale * plus_identity((P{} + static_cast<T>(2) * material.mu) * elastic, pressure);
  return outcome;
}

template <class P> WRY_INLINE Outcome<P> small_or_large(const Constants<ScalarOf<P>>& material, Trial<P>& trial) {
  const Memory<P> before = trial.memory;
  MaskOf<P> good;
  Outcome<P> outcome = series_step(material, trial, good);
  if (any_lane(~good)) {
    Trial<P> again = {trial.F, before, trial.scale};
    const Outcome<P> exact = spectral_step(material, again);
    outcome.F = choose(good, outcome.F, exact.F);
    outcome.kirchhoff = choose(good, outcome.kirchhoff, exact.kirchhoff);
    trial.memory.hardening = good ? trial.memory.hardening : again.memory.hardening;
    trial.memory.volume_correction = good ? trial.memory.volume_correction : again.memory.volume_correction;
  }
  return outcome;
}

} // namespace

template <class T>
ConstitutiveReport update_isotropic(const MaterialConstants<T>& material, const ConstitutiveTiles<T>& tiles) {
  using P = Pack<T>;
  return over_tiles<P>(material, tiles, [&](Trial<P>& trial, int, int) { return spectral_step<P>(material, trial); });
}

template <class T>
ConstitutiveReport update_isotropic_series(const MaterialConstants<T>& material, const ConstitutiveTiles<T>& tiles) {
  using P = Pack<T>;
  return over_tiles<P>(material, tiles, [&](Trial<P>& trial, int, int) { return small_or_large<P>(material, trial); });
}

template <class T>
void energy_isotropic(const MaterialConstants<T>& material, const ConstitutiveTiles<T>& tiles, T* energy) {
  using P = Pack<T>;
  const P half = all_lanes<P>(0.5), one = all_lanes<P>(1.0);
  for (int tile = 0; tile < tiles.count; ++tile) {
    for (int lane = 0; lane < TILE_WIDTH<T>; lane += LANES_OF<P>) {
      const int at1 = place<T>(tile, 1, lane);
      const Mat<P> F = load_matrix<P>(tiles.deformation + place<T>(tile, 9, lane), TILE_WIDTH<T>);
      const LeftSvd<P> svd = left_svd(F);
      const Vec<P> s = svd.stretches, e = strains_of(material.measure, s);
      P density = material.mu * dot(e, e) + half * material.lambda * sum(e) * sum(e);
      if (material.elasticity_law == Elasticity::fixed_corotated) {
        const Vec<P> d = {s.x - one, s.y - one, s.z - one};
        const P volume = s.x * s.y * s.z - one;
        density = material.mu * dot(d, d) + half * material.lambda * volume * volume;
      }
      Memory<P> memory{};
      memory.plastic_volume = load_or<P>(tiles.of(Channel::plastic_volume), at1, 1.0);
      const P scale = load_or<P>(tiles.of(Channel::stiffness_scale), at1, 1.0);
      store_lanes<P>(energy + at1, density * stiffness_factor(material, memory, scale));
    }
  }
}

WRY_MATTER_KERNELS_ISOTROPIC(template)

} // namespace wry::mpm::WRY_ISA
