#pragma once

#include <vector>

#include "sim/base/isa.h"
#include "sim/fem/fem_plan.h"
#include "sim/fem/kernels/batch.h"

namespace wry::fem {

/// The models: the kernel file <model>.kernel.cpp defines a ModelKernel of the model's name in the namespace of each
/// instruction set. A new model is its file and a line here.
#define WRY_MODELS(WRY_MODEL)                                                                                          \
  WRY_MODEL(neo_hookean)                                                                                               \
  WRY_MODEL(neo_hookean_eq16)                                                                                          \
  WRY_MODEL(stvk)                                                                                                      \
  WRY_MODEL(corotated)                                                                                                 \
  WRY_MODEL(micropolar)                                                                                                \
  WRY_MODEL(micropolar_det)                                                                                            \
  WRY_MODEL(micropolar_neo_hookean)

/// All models that have a kernel, for tests and lists.
std::vector<ElasticModel> models_with_kernels();

/// The kernel of a model; nullptr if it has none.
const ModelKernel* find_kernel(ElasticModel model, Isa isa);

/// The update of the history after a step.
AdvanceRotations find_advance_rotations(Isa isa);

} // namespace wry::fem
