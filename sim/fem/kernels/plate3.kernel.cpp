#include "sim/fem/kernels/mixed.h"

namespace wry::fem::WRY_ISA {

extern const MixedKernel plate3;
const MixedKernel plate3 = mixed_kernel<Plate3Shape>();

} // namespace wry::fem::WRY_ISA
