#include "sim/fem/linear/sparse_factor.h"

namespace wry::fem {

Result<std::unique_ptr<SparseFactor>> SparseFactor::create(const BlockMatrix&) {
  return make_error(ErrorCode::unavailable, "direct linear solves: this build has no CHOLMOD; configure with "
                                            "-DWRY_WITH_SUITESPARSE=ON, or set fem.linear_solver = \"pcg\"");
}

} // namespace wry::fem
