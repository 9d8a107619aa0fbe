#include "sim/fem/linear/block_product.h"

namespace wry::fem {

BlockProductTable select_block_products(Isa isa) {
  switch (isa) {
  case Isa::avx512:
    return avx512::block_products();
  case Isa::avx2:
    return avx2::block_products();
  case Isa::sse4:
    break;
  }
  return sse4::block_products();
}

template <> const BlockFunctions<float>& block_functions<float>(const BlockProductTable& table, int dofs) {
  return dofs == 3 ? table.float3 : table.float6;
}

template <> const BlockFunctions<double>& block_functions<double>(const BlockProductTable& table, int dofs) {
  return dofs == 3 ? table.double3 : table.double6;
}

} // namespace wry::fem
