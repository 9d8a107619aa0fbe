#include "sim/fem/kernels/classic.h"
#include "sim/fem/kernels/compressible.h"

namespace wry::fem::WRY_ISA {

namespace {

struct NeoHookeanEq16 {
  template <Order ORDER> WRY_INLINE static void add(const Element& element, PositionPart& part) {
    add_compressible<SquareLogLaw, ORDER>(element, part);
  }
};

} // namespace

extern const ModelKernel neo_hookean_eq16;
const ModelKernel neo_hookean_eq16 = classic_kernel<NeoHookeanEq16>();

} // namespace wry::fem::WRY_ISA
