#include "sim/fem/kernels/micropolar.h"

/// Eq 11 with the volume term of det F in place of lambda/2 tr(E)^2.
namespace wry::fem::WRY_ISA {

namespace {

template <bool HAS_COUPLE> struct MicropolarDet {
  static constexpr bool STRETCH = true;
  static constexpr bool COUPLE = HAS_COUPLE;

  template <Order ORDER> WRY_INLINE static void add(const Element& element, Points& points, PositionPart& part) {
    const Real weight = 0.25 * element.volume;
    const StrainModuli moduli = {weight * element.mu, Real{}, weight * (element.mu - element.mu_c)};
    add_strain<MicropolarDet, ORDER>(element, moduli, points, part);
    add_compressible<ReciprocalLaw, ORDER>(element, part);
  }
};

template <Order ORDER>
void evaluate(const Batch& batch, const NodeFields& fields, double* energy, double* gradient, double* hessian) {
  if (batch.couple_equals_shear)
    evaluate_micropolar<MicropolarDet<false>, ORDER>(batch, fields, energy, gradient, hessian);
  else
    evaluate_micropolar<MicropolarDet<true>, ORDER>(batch, fields, energy, gradient, hessian);
}

} // namespace

extern const ModelKernel micropolar_det;
const ModelKernel micropolar_det = {evaluate<Order::energy>, evaluate<Order::gradient>, evaluate<Order::hessian>};

} // namespace wry::fem::WRY_ISA
