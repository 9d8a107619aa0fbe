#include "sim/fem/kernels/mixed_table.h"

namespace wry::fem {

#define WRY_DECLARE(name) extern const MixedKernel name;
namespace sse4 {
WRY_MIXED_ELEMENTS(WRY_DECLARE)
} // namespace sse4
namespace avx2 {
WRY_MIXED_ELEMENTS(WRY_DECLARE)
} // namespace avx2
namespace avx512 {
WRY_MIXED_ELEMENTS(WRY_DECLARE)
} // namespace avx512
#undef WRY_DECLARE

const MixedKernel* find_mixed_kernel(ElementKind kind, Isa isa) {
  struct Entry {
    ElementKind kind;
    const MixedKernel* kernels[3]; ///< by Isa
  };
#define WRY_ENTRY(name) {ElementKind::name, {&sse4::name, &avx2::name, &avx512::name}},
  static constexpr Entry TABLE[] = {WRY_MIXED_ELEMENTS(WRY_ENTRY)};
#undef WRY_ENTRY
  for (const Entry& entry : TABLE) {
    if (entry.kind == kind)
      return entry.kernels[static_cast<int>(isa)];
  }
  return nullptr;
}

} // namespace wry::fem
