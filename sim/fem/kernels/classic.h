#pragma once

#include "sim/fem/kernels/element.h"

namespace wry::fem::WRY_ISA {

/// Evaluates a batch of a model of the positions alone. Energy::add<ORDER>(element, part) adds its energy times the
/// volume and, up to ORDER, its derivatives by the positions of nodes 1..3.
template <class Energy, Order ORDER>
void evaluate_classic(const Batch& batch, const NodeFields& fields, double* energy, double* gradient, double* hessian) {
  for (int lane = 0; lane < LANES; lane += WIDTH) {
    const Element element = load_element(batch, fields, lane);
    PositionPart part{};
    Energy::template add<ORDER>(element, part);
    store(energy + lane, part.energy);
    if constexpr (ORDER != Order::energy)
      store_forces(gradient + lane, 3, part.force);
    if constexpr (ORDER == Order::hessian)
      store_position_blocks(hessian + lane, 3, part.blocks);
  }
}

template <class Energy> constexpr ModelKernel classic_kernel() {
  return {evaluate_classic<Energy, Order::energy>, evaluate_classic<Energy, Order::gradient>,
          evaluate_classic<Energy, Order::hessian>};
}

} // namespace wry::fem::WRY_ISA
