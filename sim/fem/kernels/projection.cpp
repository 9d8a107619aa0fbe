#include "sim/fem/kernels/projection.h"

namespace wry::fem {

#define WRY_DECLARE(isa)                                                                                               \
  namespace isa {                                                                                                      \
  int project(double* hessian, int count, const double (*inertia)[LANES]);                                             \
  }
WRY_DECLARE(sse4)
WRY_DECLARE(avx2)
WRY_DECLARE(avx512)
#undef WRY_DECLARE

ProjectElements find_projection(Isa isa) {
  constexpr ProjectElements TABLE[] = {sse4::project, avx2::project, avx512::project};
  return TABLE[static_cast<int>(isa)];
}

} // namespace wry::fem
