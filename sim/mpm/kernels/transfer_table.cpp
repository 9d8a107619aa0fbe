#include "sim/mpm/kernels/transfer_table.h"

namespace wry::mpm {

#define WRY_DECLARE(isa)                                                                                               \
  namespace isa {                                                                                                      \
  extern const TransferKernels<float> transfers_float;                                                                 \
  extern const TransferKernels<double> transfers_double;                                                               \
  extern const StiffnessKernels<float> stiffness_float;                                                                \
  extern const StiffnessKernels<double> stiffness_double;                                                              \
  }
WRY_DECLARE(sse4)
WRY_DECLARE(avx2)
WRY_DECLARE(avx512)
#undef WRY_DECLARE

template <> const TransferKernels<float>& transfer_kernels<float>(Isa isa) {
  static const TransferKernels<float>* const TABLE[] = {&sse4::transfers_float, &avx2::transfers_float,
                                                        &avx512::transfers_float};
  return *TABLE[static_cast<int>(isa)];
}

template <> const TransferKernels<double>& transfer_kernels<double>(Isa isa) {
  static const TransferKernels<double>* const TABLE[] = {&sse4::transfers_double, &avx2::transfers_double,
                                                         &avx512::transfers_double};
  return *TABLE[static_cast<int>(isa)];
}

template <> const StiffnessKernels<float>& stiffness_kernels<float>(Isa isa) {
  static const StiffnessKernels<float>* const TABLE[] = {&sse4::stiffness_float, &avx2::stiffness_float,
                                                         &avx512::stiffness_float};
  return *TABLE[static_cast<int>(isa)];
}

template <> const StiffnessKernels<double>& stiffness_kernels<double>(Isa isa) {
  static const StiffnessKernels<double>* const TABLE[] = {&sse4::stiffness_double, &avx2::stiffness_double,
                                                          &avx512::stiffness_double};
  return *TABLE[static_cast<int>(isa)];
}

} // namespace wry::mpm
