#pragma once

#include "sim/base/isa.h"
#include "sim/mpm/grains/grain_batch.h"

namespace wry::mpm {

/// What moves grains, for an instruction set.
const GrainKernels& grain_kernels(Isa isa);

} // namespace wry::mpm
