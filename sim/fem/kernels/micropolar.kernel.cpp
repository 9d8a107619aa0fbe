#include "sim/fem/kernels/micropolar.h"

namespace wry::fem::WRY_ISA {

namespace {

/// Eq 11 with mu_c == mu: nothing depends on the couple modulus.
struct EqualModuli {
  static constexpr bool STRETCH = true;
  static constexpr bool COUPLE = false;
};

/// Eq 11 with any couple modulus.
struct AnyModuli {
  static constexpr bool STRETCH = true;
  static constexpr bool COUPLE = true;
};

template <class Terms> struct Micropolar {
  template <Order ORDER> WRY_INLINE static void add(const Element& element, Points& points, PositionPart& part) {
    const Real weight = 0.25 * element.volume;
    const StrainModuli moduli = {weight * element.mu, weight * element.lambda, weight * (element.mu - element.mu_c)};
    add_strain<Terms, ORDER>(element, moduli, points, part);
  }
};

template <Order ORDER>
void evaluate(const Batch& batch, const NodeFields& fields, double* energy, double* gradient, double* hessian) {
  if (batch.couple_equals_shear)
    evaluate_micropolar<Micropolar<EqualModuli>, ORDER>(batch, fields, energy, gradient, hessian);
  else
    evaluate_micropolar<Micropolar<AnyModuli>, ORDER>(batch, fields, energy, gradient, hessian);
}

} // namespace

extern const ModelKernel micropolar;
const ModelKernel micropolar = {evaluate<Order::energy>, evaluate<Order::gradient>, evaluate<Order::hessian>};

} // namespace wry::fem::WRY_ISA
