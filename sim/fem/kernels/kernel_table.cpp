#include "sim/fem/kernels/kernel_table.h"

namespace wry::fem {

#define WRY_DECLARE(name) extern const ModelKernel name;
namespace sse4 {
WRY_MODELS(WRY_DECLARE)
void advance_point_rotations(const Batch& batch, const NodeFields& fields, double* point_rotations);
} // namespace sse4
namespace avx2 {
WRY_MODELS(WRY_DECLARE)
void advance_point_rotations(const Batch& batch, const NodeFields& fields, double* point_rotations);
} // namespace avx2
namespace avx512 {
WRY_MODELS(WRY_DECLARE)
void advance_point_rotations(const Batch& batch, const NodeFields& fields, double* point_rotations);
} // namespace avx512
#undef WRY_DECLARE

namespace {

struct Entry {
  ElasticModel model;
  const ModelKernel* kernels[3]; ///< by Isa
};

#define WRY_ENTRY(name) {ElasticModel::name, {&sse4::name, &avx2::name, &avx512::name}},
constexpr Entry TABLE[] = {WRY_MODELS(WRY_ENTRY)};
#undef WRY_ENTRY

constexpr AdvanceRotations ADVANCE[] = {sse4::advance_point_rotations, avx2::advance_point_rotations,
                                        avx512::advance_point_rotations};

} // namespace

std::vector<ElasticModel> models_with_kernels() {
  std::vector<ElasticModel> models;
  for (const Entry& entry : TABLE)
    models.push_back(entry.model);
  return models;
}

const ModelKernel* find_kernel(ElasticModel model, Isa isa) {
  for (const Entry& entry : TABLE) {
    if (entry.model == model)
      return entry.kernels[static_cast<int>(isa)];
  }
  return nullptr;
}

AdvanceRotations find_advance_rotations(Isa isa) {
  return ADVANCE[static_cast<int>(isa)];
}

} // namespace wry::fem
