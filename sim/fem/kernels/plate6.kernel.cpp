#include "sim/fem/kernels/mixed.h"

namespace wry::fem::WRY_ISA {

extern const MixedKernel plate6;
const MixedKernel plate6 = mixed_kernel<Plate6Shape>();

} // namespace wry::fem::WRY_ISA
