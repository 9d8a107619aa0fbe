#pragma once

#include "sim/mpm/constitutive.h"
#include "sim/mpm/matter/kernels/decompose.h"

/// Return maps across lanes; the scalar originals are in plastic_law.cpp, equations in spec S5.
namespace wry::mpm::WRY_ISA {

/// What a lane remembers of its flow, and what its yield limits are multiplied by.
template <class P> struct Memory {
  P hardening, plastic_volume, volume_correction;
  P strength;
};

/// alpha of Drucker-Prager after a flow of q.
template <class P> WRY_INLINE P friction_alpha(const MaterialConstants<ScalarOf<P>>& material, P q) {
  using T = ScalarOf<P>;
  if (!material.hardens)
    return P{} + material.friction_alpha;
  const T* h = material.friction_angle;
  const P angle = (h[1] * q - h[3]) * exponential(-h[2] * q) + h[0];
  const P s = sine(angle);
  return static_cast<T>(2 * 0.81649658092772603273) * s / (static_cast<T>(3) - s);
}

/// Drucker-Prager by the deviator of the fictitious strain alone, without its axes. `volume_row` is tr((A^E)^-1 : .),
/// the three normal and three (doubled) shear weights; nullptr: flow along the deviator.
template <class P>
WRY_INLINE MaskOf<P> return_drucker_prager(const MaterialConstants<ScalarOf<P>>& material, Sym<P>& E, Memory<P>& memory,
                                           const Sym<P>* volume_row) {
  using T = ScalarOf<P>;
  const P alpha = memory.strength * friction_alpha(material, memory.hardening);
  const P c = (static_cast<T>(3) * material.lambda + static_cast<T>(2) * material.mu) * alpha /
              (P{} + static_cast<T>(2) * material.mu);
  const P tr = trace(E);
  const Sym<P> deviator = plus_identity(E, tr * static_cast<T>(-1.0 / 3.0));
  const P length = root(contracted(deviator, deviator));
  const P norm = root(contracted(E, E));
  const MaskOf<P> expands = tr >= 0;
  const P excess = length + c * tr;
  const MaskOf<P> slides = ~expands & (excess > 0);
  const MaskOf<P> opens = expands & (norm > 0);
  const P safe_length = length > 0 ? length : all_lanes<P>(1.0);
  P along = excess / safe_length, shift = P{};
  if (volume_row != nullptr) {
    const P all = volume_row->xx + volume_row->yy + volume_row->zz;
    const P of_deviator = volume_row->xx * deviator.xx + volume_row->yy * deviator.yy + volume_row->zz * deviator.zz +
                          volume_row->yz * deviator.yz + volume_row->zx * deviator.zx + volume_row->xy * deviator.xy;
    const P k = -of_deviator / all;
    const P denominator = length + static_cast<T>(3) * k * c;
    const P step = excess / denominator;
    const MaskOf<P> possible = (denominator > 0) & (step > 0) & (step <= 1) & (tr - static_cast<T>(3) * step * k <= 0);
    along = possible ? step : along;
    shift = possible ? step * k : P{};
  }
  const Sym<P> slid = plus_identity(E - along * deviator, -shift);
  const Sym<P> nothing = {P{}, P{}, P{}, P{}, P{}, P{}};
  E = choose(opens, nothing, choose(slides, slid, E));
  memory.hardening = memory.hardening + (opens ? norm : slides ? excess : P{});
  return opens | slides;
}

/// Principal stretches of principal strains and the other way round.
template <class P> WRY_INLINE Vec<P> stretches_of(StrainMeasure measure, const Vec<P>& e) {
  if (measure == StrainMeasure::hencky)
    return {exponential(e.x), exponential(e.y), exponential(e.z)};
  const P one = all_lanes<P>(1.0);
  return {e.x + one, e.y + one, e.z + one};
}
template <class P> WRY_INLINE Vec<P> strains_of(StrainMeasure measure, const Vec<P>& s) {
  if (measure == StrainMeasure::hencky)
    return {logarithm(s.x), logarithm(s.y), logarithm(s.z)};
  const P one = all_lanes<P>(1.0);
  return {s.x - one, s.y - one, s.z - one};
}

template <class P>
WRY_INLINE MaskOf<P> return_snow(const MaterialConstants<ScalarOf<P>>& material, Vec<P>& e, Memory<P>& memory) {
  using T = ScalarOf<P>;
  const P one = all_lanes<P>(1.0), least = all_lanes<P>(1e-6);
  const P low = one - material.critical_compression * memory.strength;
  const P high = one + material.critical_stretch * memory.strength;
  const Vec<P> s = stretches_of(material.measure, e);
  const auto clip = [&](P x) { return smaller(larger(x, low), high); };
  const Vec<P> t = {clip(s.x), clip(s.y), clip(s.z)};
  const MaskOf<P> moved = (t.x != s.x) | (t.y != s.y) | (t.z != s.z);
  const P growth = (larger(magnitude(s.x), least) / t.x) * (larger(magnitude(s.y), least) / t.y) *
                   (larger(magnitude(s.z), least) / t.z);
  const P volume = smaller(larger(memory.plastic_volume * growth, all_lanes<P>(0.1)), all_lanes<P>(10.0));
  memory.plastic_volume = moved ? volume : memory.plastic_volume;
  e = choose(moved, strains_of(material.measure, t), e);
  static_cast<void>(sizeof(T));
  return moved;
}

/// Tresca, to the nearest point: the same for every order of the strains.
template <class P>
WRY_INLINE MaskOf<P> return_shear(const MaterialConstants<ScalarOf<P>>& material, Vec<P>& e, const Memory<P>& memory) {
  using T = ScalarOf<P>;
  const P k = material.shear_limit * memory.strength, third = all_lanes<P>(1.0 / 3.0), half = all_lanes<P>(0.5);
  const P high = larger(e.x, larger(e.y, e.z)), low = smaller(e.x, smaller(e.y, e.z));
  const P total = sum(e), mean = third * total;
  const P middle = larger(smaller(e.x, e.y), smaller(larger(e.x, e.y), e.z));
  const P excess = high - low - k;
  const MaskOf<P> moved = excess > 0;
  const P cut_high = high - half * excess, cut_low = low + half * excess;
  const MaskOf<P> two_high = middle > cut_high, two_low = ~two_high & (middle < cut_low);
  const P new_high = two_high ? mean + third * k : two_low ? mean + static_cast<T>(2) * third * k : cut_high;
  const P new_low = two_high ? mean - static_cast<T>(2) * third * k : two_low ? mean - third * k : cut_low;
  const P new_middle = two_high ? new_high : two_low ? new_low : middle;
  // A strain that equals the highest or the lowest goes with it; ties lie on an edge, where both answers agree.
  const auto place = [&](P x) { return x == high ? new_high : x == low ? new_low : new_middle; };
  const Vec<P> next = {place(e.x), place(e.y), place(e.z)};
  e = choose(moved, next, e);
  return moved;
}

template <class P>
WRY_INLINE MaskOf<P> return_principal(const MaterialConstants<ScalarOf<P>>& material, Vec<P>& e, Memory<P>& memory) {
  if (material.plasticity == Plasticity::snow)
    return return_snow(material, e, memory);
  return return_shear(material, e, memory);
}

/// Principal stresses conjugate to the strains.
template <class P>
WRY_INLINE Vec<P> fixed_corotated_stress(const MaterialConstants<ScalarOf<P>>& material, const Vec<P>& e) {
  using T = ScalarOf<P>;
  const P one = all_lanes<P>(1.0);
  const Vec<P> s = stretches_of(material.measure, e);
  const P J = s.x * s.y * s.z, pressure = material.lambda * (J - one) * J;
  const auto of = [&](P x) {
    const P kirchhoff = static_cast<T>(2) * material.mu * x * (x - one) + pressure;
    return material.measure == StrainMeasure::hencky ? kirchhoff : kirchhoff / x;
  };
  return {of(s.x), of(s.y), of(s.z)};
}

/// exp(xi (1 - J_p)) of snow times what varies in space: the factor on all moduli.
template <class P>
WRY_INLINE P stiffness_factor(const MaterialConstants<ScalarOf<P>>& material, const Memory<P>& memory, P scale) {
  if (material.plasticity != Plasticity::snow)
    return scale;
  return scale * exponential(material.snow_hardening * (all_lanes<P>(1.0) - memory.plastic_volume));
}

} // namespace wry::mpm::WRY_ISA
