#pragma once

#include "sim/base/isa.h"
#include "sim/fem/fem_plan.h"
#include "sim/fem/kernels/mixed_batch.h"

namespace wry::fem {

/// Elements with a mixed kernel: the kernel file <kind>.kernel.cpp defines a MixedKernel of that name. A new element is
/// its shape (mixed_shape.h), its file and a line here.
#define WRY_MIXED_ELEMENTS(WRY_ELEMENT)                                                                                \
  WRY_ELEMENT(tet4_one_point)                                                                                          \
  WRY_ELEMENT(tet10)                                                                                                   \
  WRY_ELEMENT(plate3)                                                                                                  \
  WRY_ELEMENT(plate6)

/// The kernel of a kind of element; nullptr if it is not a mixed one.
const MixedKernel* find_mixed_kernel(ElementKind kind, Isa isa);

} // namespace wry::fem
