#include "sim/fem/kernels/mixed.h"

namespace wry::fem::WRY_ISA {

extern const MixedKernel tet10;
const MixedKernel tet10 = mixed_kernel<Tet10Shape>();

} // namespace wry::fem::WRY_ISA
