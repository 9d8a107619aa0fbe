#pragma once

#include "sim/base/isa.h"
#include "sim/fem/linear/block_product_isa.h"

namespace wry::fem {

/// The products for an instruction set.
BlockProductTable select_block_products(Isa isa);

/// The one of the table for a scalar and a number of unknowns per node.
template <class Scalar> const BlockFunctions<Scalar>& block_functions(const BlockProductTable& table, int dofs);

} // namespace wry::fem
