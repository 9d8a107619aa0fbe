#pragma once

#include "sim/fem/linear/linear_method.h"

namespace wry::fem {

/// Workspace of conjugate gradients, kept between solves.
template <class Scalar> struct ConjugateGradientVectors { AlignedVector<Scalar> x, r, z, p, q; };

/// r . r and r . z
struct ResidualDots {
  double squared = 0.0;
  double preconditioned = 0.0;
};

/// An approximate inverse, symmetric and positive definite, on padded vectors.
template <class Scalar> class Preconditioner {
public:
  virtual ~Preconditioner() = default;
  /// z <- M^-1 r; surplus entries stay zero. Returns r . z.
  virtual double apply(const AlignedVector<Scalar>& r, AlignedVector<Scalar>& z) const = 0;
  /// x += alpha p, r -= alpha q, z = M^-1 r.
  virtual ResidualDots advance(ConjugateGradientVectors<Scalar>& work, Scalar alpha, const Threads& threads) const;
};

/// Inverse diagonal blocks.
template <class Scalar> class BlockJacobi final : public Preconditioner<Scalar> {
public:
  /// Takes the blocks of the matrix; false if one is not positive definite.
  bool update(const BlockMatrix& matrix, const Threads& threads);
  double apply(const AlignedVector<Scalar>& r, AlignedVector<Scalar>& z) const override;
  ResidualDots advance(ConjugateGradientVectors<Scalar>& work, Scalar alpha, const Threads& threads) const override;

private:
  const BlockMatrix* m_matrix = nullptr;
  const Threads* m_threads = nullptr;
  std::vector<AlignedVector<Scalar>> m_inverses; ///< per section, per node: d columns of stride entries
};

/// Solves A x = b from x = 0 until |r| <= tolerance |b|. Stops with `indefinite` at non-positive curvature.
template <class Scalar>
SolveReport conjugate_gradients(const BlockMatrix& matrix, const Preconditioner<Scalar>& preconditioner,
                                const std::vector<double>& right_side, double tolerance, int max_iterations,
                                ConjugateGradientVectors<Scalar>& work, const Threads& threads,
                                std::vector<double>& solution);

} // namespace wry::fem
