#include "sim/mpm/grains/grain_kernels.h"

namespace wry::mpm {

#define WRY_DECLARE(isa)                                                                                               \
  namespace isa {                                                                                                      \
  extern const GrainKernels grain_kernels;                                                                             \
  }
WRY_DECLARE(sse4)
WRY_DECLARE(avx2)
WRY_DECLARE(avx512)
#undef WRY_DECLARE

const GrainKernels& grain_kernels(Isa isa) {
  static const GrainKernels* const TABLE[] = {&sse4::grain_kernels, &avx2::grain_kernels, &avx512::grain_kernels};
  return *TABLE[static_cast<int>(isa)];
}

} // namespace wry::mpm
