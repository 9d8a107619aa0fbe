#include "sim/fem/kernels/micropolar.h"

/// Eq 16: the positions' energy is that of neo_hookean_eq16; rotations enter through mu_c |skew U|^2 alone.
namespace wry::fem::WRY_ISA {

namespace {

struct MicropolarNeoHookean {
  static constexpr bool STRETCH = false;
  static constexpr bool COUPLE = true;

  template <Order ORDER> WRY_INLINE static void add(const Element& element, Points& points, PositionPart& part) {
    const StrainModuli moduli = {Real{}, Real{}, -0.25 * element.volume * element.mu_c};
    add_strain<MicropolarNeoHookean, ORDER>(element, moduli, points, part);
    add_compressible<SquareLogLaw, ORDER>(element, part);
  }
};

} // namespace

extern const ModelKernel micropolar_neo_hookean;
const ModelKernel micropolar_neo_hookean = micropolar_kernel<MicropolarNeoHookean>();

} // namespace wry::fem::WRY_ISA
