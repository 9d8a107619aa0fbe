#include "sim/fem/element_kernels.h"

#include <cassert>
#include <cstddef>

#include "sim/fem/kernels/kernel_table.h"

namespace wry::fem {

namespace {

const double* batch_of(const AlignedVector<double>& entries, int per_element, int batch) {
  return entries.empty() ? nullptr : entries.data() + static_cast<std::size_t>(batch) * per_element * LANES;
}

BatchCurvature curvature_of(const ElementGroup& group) {
  switch (group.curvature) {
  case CurvatureModel::none:
    return BatchCurvature::none;
  case CurvatureModel::isotropic:
    return BatchCurvature::isotropic;
  case CurvatureModel::orthotropic:
    return BatchCurvature::orthotropic;
  }
  return BatchCurvature::none;
}

Batch batch_of(const ElementGroup& group, int batch) {
  Batch view;
  view.curvature = curvature_of(group);
  view.couple_equals_shear = group.couple_equals_shear;
  view.nodes = group.nodes.data() + static_cast<std::size_t>(batch) * 4 * LANES;
  view.shape_gradients = batch_of(group.shape_gradients, 9, batch);
  view.volume = batch_of(group.volume, 1, batch);
  view.mu = batch_of(group.mu, 1, batch);
  view.lambda = batch_of(group.lambda, 1, batch);
  view.mu_c = batch_of(group.mu_c, 1, batch);
  view.curvature_moduli = batch_of(group.curvature_moduli, group.curvature == CurvatureModel::isotropic ? 3 : 9, batch);
  view.curvature_basis = batch_of(group.curvature_basis, 9, batch);
  view.rest_curvature = batch_of(group.rest_curvature, 36, batch);
  view.point_rotations = batch_of(group.point_rotations, 16, batch);
  return view;
}

template <Isa ISA> void energy_of(const ElementGroup& group, const NodeFields& fields, int batch, double* energy) {
  find_kernel(group.model, ISA)->energy(batch_of(group, batch), fields, energy, nullptr, nullptr);
}

template <Isa ISA>
void gradient_of(const ElementGroup& group, const NodeFields& fields, int batch, BatchDerivatives& out) {
  find_kernel(group.model, ISA)->gradient(batch_of(group, batch), fields, out.energy, out.gradient, nullptr);
}

template <Isa ISA>
void hessian_of(const ElementGroup& group, const NodeFields& fields, int batch, BatchDerivatives& out) {
  find_kernel(group.model, ISA)->hessian(batch_of(group, batch), fields, out.energy, out.gradient, out.hessian);
}

template <Isa ISA> void advance(ElementGroup& group, const NodeFields& fields, int batch) {
  const std::size_t first = static_cast<std::size_t>(batch) * 16 * LANES;
  find_advance_rotations(ISA)(batch_of(group, batch), fields, group.point_rotations.data() + first);
}

template <Isa ISA> ElementKernel element_kernel(const ElementGroup& group) {
  return {energy_of<ISA>, gradient_of<ISA>, hessian_of<ISA>, is_micropolar(group.model) ? advance<ISA> : nullptr};
}

} // namespace

ElementKernel select_kernel(const ElementGroup& group, Isa isa) {
  switch (isa) {
  case Isa::sse4:
    return element_kernel<Isa::sse4>(group);
  case Isa::avx2:
    return element_kernel<Isa::avx2>(group);
  case Isa::avx512:
    return element_kernel<Isa::avx512>(group);
  }
  return {};
}

} // namespace wry::fem
