#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sim/base/aligned.h"
#include "sim/base/parallel.h"
#include "sim/base/types.h"
#include "sim/mpm/grid.h"
#include "sim/mpm/semi_implicit_settings.h"

namespace wry::mpm {

/// What contact leaves of a node's freedom in the linear solve.
struct NodeConstraint {
  enum class Kind {
    none,   ///< any change
    across, ///< no change along `direction`
    along,  ///< no change but along `direction`
    all,    ///< no change
  };
  std::int32_t node = 0; ///< in its block, 0 to 63
  Kind kind = Kind::all;
  Vec3 direction = Vec3::Zero(); ///< unit
};

/// What a linear solve took.
struct SolveReport {
  int iterations = 0;
  double residual = 0.0; ///< of the last over the first
};

/// The linear solve of a semi-implicit step: conjugate gradients without a matrix, preconditioned with the masses. That
/// one keeps momentum and angular momentum to round-off wherever it is stopped: K does no work on rigid motions, so
/// that no residual has a part along them. Sums are taken block by block in order: the bits do not depend on the
/// threads.
template <class Scalar> class SemiImplicitSolver {
public:
  /// to <- K from; velocities and forces of all blocks.
  using Stiffness = std::function<void(const Scalar* from, Scalar* to)>;

  /// For a grid of so many blocks.
  void fit(std::size_t blocks);
  /// Momentum and mass of the nodes at the start of the step, without its forces: filled by the caller.
  Scalar* start() { return m_start.data(); }
  /// Constraints of a block: filled by the caller, emptied by fit().
  std::vector<NodeConstraint>& constraints(std::size_t block) { return m_constraints[block]; }

  /// Brings the velocities of the grid from those of an explicit step, after contact, to those of the semi-implicit
  /// one.
  SolveReport solve(Grid<Scalar>& grid, double dt, const Vec3& gravity, const SemiImplicit& settings,
                    const Stiffness& stiffness, const Threads& threads);

  std::size_t memory_bytes() const;

private:
  /// Takes what constraints forbid out of a block of `vector`.
  void project(std::size_t block, Scalar* vector) const;
  double sum_blocks(const Threads& threads, const std::function<double(std::size_t)>& of_block);

  std::size_t m_blocks = 0;
  AlignedVector<Scalar> m_start, m_velocity, m_residual, m_direction, m_image;
  std::vector<std::vector<NodeConstraint>> m_constraints;
  std::vector<double> m_sums; ///< per block
};

extern template class SemiImplicitSolver<float>;
extern template class SemiImplicitSolver<double>;

} // namespace wry::mpm
