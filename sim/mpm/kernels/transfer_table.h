#pragma once

#include "sim/base/isa.h"
#include "sim/mpm/kernels/transfer.h"

namespace wry::mpm {

/// The transfers for an instruction set.
template <class Scalar> const TransferKernels<Scalar>& transfer_kernels(Isa isa);
template <class Scalar> const StiffnessKernels<Scalar>& stiffness_kernels(Isa isa);

} // namespace wry::mpm
