#pragma once

#include <array>
#include <functional>
#include <vector>

#include "sim/fem/element_kernels.h"
#include "sim/fem/terms/energy_term.h"

namespace wry::fem {

/// The strain energy of one body's elements. Batches are gathered in chunks, and chunks that share no node in colours:
/// colours run one after the other, the chunks of a colour in parallel, so that sums do not depend on the threads.
class ElementTerm final : public EnergyTerm {
public:
  /// `rest_points`: 4 rest positions per element, row 4 * element + point, for the rest curvature (may be empty).
  ElementTerm(ElementGroup group, Points rest_points, RestCurvature rest_curvature, Isa isa, const Threads& threads);

  std::string_view name() const override { return "elements"; }
  /// False when no kernel computes this model.
  bool has_kernel() const { return m_kernel.hessian != nullptr; }
  const ElementGroup& group() const { return m_group; }
  ElementGroup& group() { return m_group; }
  /// The nodes of each element, ascending.
  std::vector<std::array<std::int32_t, 4>> element_nodes() const;
  /// The nodes' stored rotations, which the owner keeps in place; unused by classic models.
  void bind_rotations(const Quaternions* rotations) { m_rotations = rotations; }

  /// Evaluates the rest curvature at a time.
  void update_rest_curvature(double time);
  std::size_t memory_bytes() const;

  void begin_solve(const Stage& stage, const Trial& trial) override;
  double energy(const Stage& stage, const Trial& trial) const override;
  double add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const override;
  int add_hessian(const Stage& stage, const Trial& trial, Projection projection, BlockMatrix& matrix) const override;

  /// After convergence: turns the rotations that the quadrature points carry.
  void advance_rotations(const Trial& trial);
  /// Energy of each element [J].
  std::vector<double> element_energies(const Trial& trial) const;
  /// Energy without its curvature part [J].
  double elastic_energy(const Trial& trial);
  /// Where the unknowns of nodes stand; must be called once before derivatives.
  void bind_layout(const DofLayout& layout, const BlockMatrix& matrix);

private:
  struct Chunk {
    int begin = 0, end = 0; ///< batches
  };

  void colour_chunks();
  NodeFields fields_of(const Trial& trial) const;
  int lanes_of(int batch) const;
  void for_each_chunk(const std::function<void(int chunk)>& body) const;
  template <int D> void scatter_gradient(int batch, const BatchDerivatives& in, double beta, double* gradient) const;
  template <int D> void scatter_hessian(int batch, const BatchDerivatives& in, double scale, double* values) const;

  ElementGroup m_group;
  Isa m_isa;
  ElementKernel m_kernel;
  Points m_rest_points;
  RestCurvature m_rest_curvature;
  double m_rest_curvature_time = 0.0;
  bool m_rest_curvature_known = false;
  const Threads& m_threads;
  const Quaternions* m_rotations = nullptr;
  const DofLayout* m_layout = nullptr;
  std::vector<Chunk> m_chunks;
  std::vector<std::vector<int>> m_colours;   ///< chunk numbers
  std::vector<std::int32_t> m_block_numbers; ///< batch-major, 10 per element, lanes innermost
  int m_section = 0;
};

} // namespace wry::fem
