#pragma once

#include "sim/mpm/kernels/transfer.h"

/// What carries grains: shared with kernel files, so plain arrays.
namespace wry::mpm {

inline constexpr int HALO_NODES = HALO_SIDE * HALO_SIDE * HALO_SIDE;

/// What grains of a block see of the grid: nodes as in a halo. Rows are read a node further, with weight 0.
struct FlowNodes {
  alignas(64) float flow[HALO_VALUES];       ///< velocity times activity [m/s], and activity: 0 or 1
  alignas(64) float density[HALO_NODES + 4]; ///< share of rho_0
  float least_density = 0.0F;                ///< of all nodes
  double origin[3] = {0.0, 0.0, 0.0};        ///< the block's first node, in cells
  double cell = 0.0;                         ///< h [m]
};

/// Grains that are carried together, whatever the instruction set.
inline constexpr int GRAINS_AT_ONCE = 16;
struct GrainBatch {
  alignas(64) double position[3][GRAINS_AT_ONCE];    ///< [m]
  alignas(64) double velocity[3][GRAINS_AT_ONCE];    ///< [m/s]
  alignas(64) double spin[3][GRAINS_AT_ONCE];        ///< [rad/s]; out
  alignas(64) double orientation[4][GRAINS_AT_ONCE]; ///< unit quaternions w, x, y, z
  alignas(64) double own[GRAINS_AT_ONCE];            ///< share of a grain's own velocity in its next
  bool carried[GRAINS_AT_ONCE];                      ///< out: the rest is as it was where this is false
};

struct GrainMotion {
  double dt = 0.0;       ///< [s]
  double thinnest = 0.0; ///< share of rho_0 below which matter carries no grain
  double jeffery = 0.0;  ///< l of grains that turn by the flow's stretch (turns_by_flow)
  bool turns_by_flow = false;
};

/// Brings the first `count` grains of a batch forward with the matter: RK2, whose midpoint is predicted with the
/// velocity of the midpoint before, which leaves the order and saves half of the interpolation; orientations by shape
/// matching (S7) or by Jeffery's equation. A grain's answer depends on nothing but itself and the nodes around it.
using CarryGrains = void (*)(const FlowNodes& nodes, const GrainMotion& motion, int count, GrainBatch& batch);

/// Velocities [m/s] and masses of a halo as a flow: nodes with less than `least_share` of a full cell's mass are not
/// active. All but origin and cell are filled in.
template <class Scalar>
using ShapeFlow = void (*)(const Scalar* halo, double mass_of_full_cell, double least_share, FlowNodes& nodes);

struct GrainKernels {
  CarryGrains carry;
  ShapeFlow<float> shape_flow_float;
  ShapeFlow<double> shape_flow_double;
};

} // namespace wry::mpm
