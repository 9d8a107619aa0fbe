#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "sim/base/parallel.h"
#include "sim/base/result.h"
#include "sim/base/types.h"
#include "sim/fem/fem_plan.h"
#include "sim/fem/linear/block_matrix.h"
#include "sim/state/state_archive.h"

namespace wry::fem {

/// How a solve ended.
enum class SolveEnd {
  solved,
  /// The matrix is not positive definite. Iterations give what they had before they met negative curvature, which is a
  /// direction of descent; a factorisation gives an empty solution.
  indefinite,
  unfinished, ///< the iteration limit came first; the solution is the best there is
};

struct SolveReport {
  SolveEnd end = SolveEnd::solved;
  int iterations = 0;
  double relative_residual = 0.0; ///< |b - A x| / |b| as the method knows it
};

/// A x = b for one Newton direction.
struct LinearProblem {
  const BlockMatrix& matrix;             ///< with held unknowns turned into identity rows and the float copy renewed
  const std::vector<double>& right_side; ///< packed; zero at held unknowns
  double tolerance = 1e-3;               ///< relative residual that is enough
  /// Rotation of each node since rest, for preconditioners that turn with the body; computed when asked for.
  const std::function<const std::vector<Mat3>&()>& node_rotations;
};

/// A way to solve linear systems of one pattern; keeps what may be reused.
class LinearMethod {
public:
  virtual ~LinearMethod() = default;
  /// `solution` is packed and overwritten. Deterministic: no decision rests on measured time.
  virtual SolveReport solve(const LinearProblem& problem, std::vector<double>& solution) = 0;
  /// What must survive a checkpoint so that the next solve gives the same bits.
  virtual void save(StateArchive& archive) const { (void)archive; }
  virtual Status restore(const StateArchive& archive) {
    (void)archive;
    return {};
  }
  virtual std::size_t memory_bytes() const { return 0; }
  /// What save() adds to a checkpoint once there is something to be kept [B].
  virtual std::size_t saved_bytes() const { return 0; }
};

/// Conjugate gradients, preconditioned by the inverse diagonal blocks; in float where the tolerance allows. After
/// `most_iterations` of a direction, and after far fewer on small meshes, it answers with what it has: unfinished.
std::unique_ptr<LinearMethod> make_block_jacobi_pcg(const BlockMatrix& matrix, const Threads& threads,
                                                    int most_iterations = std::numeric_limits<int>::max());

/// A new factor for each matrix. Errors: unavailable without CHOLMOD, out_of_memory.
Result<std::unique_ptr<LinearMethod>> make_cholesky(const BlockMatrix& matrix);

/// Conjugate gradients, preconditioned by the factor of an earlier matrix turned along with the nodes; renewed when its
/// iterations cost more than a factor, by counted operations. Errors: as make_cholesky.
Result<std::unique_ptr<LinearMethod>> make_stale_cholesky(const BlockMatrix& matrix, const Threads& threads);

/// Block-Jacobi conjugate gradients that hand a direction over to a stale factor when it has taken
/// `iterations_worth_a_factor`, and the directions after it too, before they are tried again: what a mesh and its
/// materials promise of the conditioning is sometimes not kept. Without memory for a factor it goes on without.
std::unique_ptr<LinearMethod> make_pcg_or_factor(const BlockMatrix& matrix, const Threads& threads,
                                                 int iterations_worth_a_factor);

} // namespace wry::fem
