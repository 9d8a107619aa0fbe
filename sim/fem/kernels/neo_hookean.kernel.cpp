#include "sim/fem/kernels/classic.h"
#include "sim/fem/kernels/compressible.h"

namespace wry::fem::WRY_ISA {

namespace {

struct NeoHookean {
  template <Order ORDER> WRY_INLINE static void add(const Element& element, PositionPart& part) {
    add_compressible<LogLaw, ORDER>(element, part);
  }
};

} // namespace

extern const ModelKernel neo_hookean;
const ModelKernel neo_hookean = classic_kernel<NeoHookean>();

} // namespace wry::fem::WRY_ISA
