#include "sim/fem/kernels/mixed.h"

namespace wry::fem::WRY_ISA {

extern const MixedKernel tet4_one_point;
const MixedKernel tet4_one_point = mixed_kernel<Tet4OnePointShape>();

} // namespace wry::fem::WRY_ISA
