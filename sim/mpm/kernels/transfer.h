#pragma once

#include "sim/mpm/constitutive.h"

/// What transfers between particles and the grid share with their callers. Seen by kernel files: plain structs.
namespace wry::mpm {

/// The grid is made of blocks of 4^3 nodes with 4 values each, z running fastest: momentum or velocity, and mass.
inline constexpr int BLOCK_SIDE = 4;
inline constexpr int NODE_VALUES = 4;
inline constexpr int BLOCK_VALUES = BLOCK_SIDE * BLOCK_SIDE * BLOCK_SIDE * NODE_VALUES;

/// Particles of a block are scattered to and gathered from a copy of the nodes around it. Sorted particles reach nodes
/// 0 to 5 of their block along each axis; the copy has a node more on both sides, so that they may stray by a cell
/// before they must be sorted again. Nodes -1 to 6.
inline constexpr int HALO_SIDE = 8;
/// The last rows are read and written a node further, with weight 0.
inline constexpr int HALO_VALUES = (HALO_SIDE * HALO_SIDE * HALO_SIDE + 1) * NODE_VALUES;
/// A block and its neighbours, z fastest.
inline constexpr int NEIGHBOURS = 27;

/// Positions, in cells from the block's first node, of which transfers stay within the halo.
inline constexpr double LEAST_POSITION = -0.5;
inline constexpr double POSITION_END = 5.5;

/// Which gradient acts as a force and which one deforms (spec S6).
enum class Transfer {
  gradient, ///< of the weights: second order
  mls,      ///< moving least squares, L = C: cheaper, first order
};

/// A run of particles of one set in one block.
template <class Scalar> struct TransferRun {
  int count = 0;     ///< of particles, in ceil(count / TILE_WIDTH) tiles
  Scalar dt = 0;     ///< [s]
  Scalar cell = 0;   ///< h [m]
  Scalar mass = 0;   ///< of a particle [kg]
  Scalar volume = 0; ///< of a particle at rest [m^3]
  Scalar* position = nullptr;
  Scalar* velocity = nullptr;
  Scalar* affine = nullptr;
  const MaterialConstants<Scalar>* material = nullptr;
  ConstitutiveKernel<Scalar> update = nullptr;
  const TangentKernel<Scalar>* tangent = nullptr; ///< of semi-implicit steps, with what it has frozen of this run
  const Scalar* frozen = nullptr;
  /// F, tau and the state of the run; the kernels fill in the rest.
  ConstitutiveTiles<Scalar> tiles;
};

/// What a gather tells about a run.
struct GatherReport {
  double max_speed_squared = 0.0;    ///< [m^2/s^2]
  double max_gradient_squared = 0.0; ///< of the Frobenius norm of L [1/s^2]
  double sum_speed_squared = 0.0;    ///< over the particles [m^2/s^2]
  bool strayed = false;              ///< a particle has left the halo, or is nowhere
  ConstitutiveReport material;       ///< failed_lane: counted from the first of the run
};

/// Adds momentum, after dt of the internal forces, and mass of a run to the halo.
template <class Scalar> using ScatterKernel = void (*)(const TransferRun<Scalar>& run, Scalar* halo);

/// New velocities, affine fields and positions of a run from the velocities in the halo; then the material's update.
template <class Scalar> using GatherKernel = GatherReport (*)(const TransferRun<Scalar>& run, const Scalar* halo);

/// Adds a halo to the 27 blocks around it, or copies them into it.
template <class Scalar> using AddHaloKernel = void (*)(const Scalar* halo, Scalar* const* blocks);
template <class Scalar> using ReadHaloKernel = void (*)(const Scalar* const* blocks, Scalar* halo);

/// Adds K v of a run, v being the velocities in a halo: V sigma(sym grad v) grad w.
template <class Scalar>
using StiffnessKernel = void (*)(const TransferRun<Scalar>& run, const Scalar* velocities, Scalar* forces);
template <class Scalar> struct StiffnessKernels { StiffnessKernel<Scalar> apply[2]; /**< by Transfer */ };

template <class Scalar> struct TransferKernels {
  ScatterKernel<Scalar> scatter[2]; ///< by Transfer
  GatherKernel<Scalar> gather[2];   ///< by Transfer
  AddHaloKernel<Scalar> add_halo;
  ReadHaloKernel<Scalar> read_halo;
};

} // namespace wry::mpm
