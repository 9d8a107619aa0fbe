#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "sim/fem/body_elements.h"
#include "sim/fem/element_kernels.h"
#include "sim/fem/inertia_shares.h"
#include "sim/fem/kernels/projection.h"

namespace wry::fem {

/// The strain energy of one body's linear tets. Batches are gathered in chunks, and chunks that share no node in
/// colours: colours run one after the other, the chunks of a colour in parallel, so that sums do not depend on the
/// threads.
class ElementTerm final : public BodyElements {
public:
  /// `rest_places`: 4 per element, number 4 * element + point, for the rest curvature (may be empty).
  ElementTerm(ElementGroup group, std::vector<RestPlace> rest_places, RestCurvature rest_curvature, Isa isa,
              const Threads& threads);

  std::string_view name() const override { return "elements"; }
  /// False when no kernel computes this model.
  bool has_kernel() const { return m_kernel.hessian != nullptr; }
  int element_count() const override { return m_group.element_count; }
  double element_volume(int element) const override { return m_group.volume[static_cast<std::size_t>(element)]; }
  std::vector<std::array<std::int32_t, 4>> node_quadruples() const override;
  bool has_curvature() const override { return m_group.curvature != CurvatureModel::none; }
  std::span<double> point_rotations() override { return m_group.point_rotations; }
  void bind_rotations(const Quaternions* rotations) override { m_rotations = rotations; }
  void bind_model(const FemModel& model, const BlockMatrix& matrix) override;
  void update_rest_curvature(double time) override;
  const ElementGroup* tet_group() const override { return &m_group; }

  void reset_point_rotations(PointRotations rule) override;
  void freeze_rest_curvature() override { m_rest_curvature_moves = false; }

  void begin_solve(const Stage& stage, const Trial& trial) override;
  double energy(const Stage& stage, const Trial& trial) const override;
  double add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const override;
  int add_hessian(const Stage& stage, const Trial& trial, Projection projection, BlockMatrix& matrix) const override;

  void advance_rotations(const Trial& trial) override;
  std::vector<double> element_energies(const Trial& trial) const override;
  double elastic_energy(const Trial& trial) override;
  void add_deformations(const Points& positions, std::vector<Mat3>& sums) const override;
  std::size_t memory_bytes() const override;
  std::vector<double> elastic_energies(const Trial& trial) override;

private:
  struct Chunk {
    int begin = 0, end = 0; ///< batches
  };

  void colour_chunks();
  NodeFields fields_of(const Trial& trial) const;
  int lanes_of(int batch) const;
  void for_each_chunk(const std::function<void(int chunk)>& body) const;
  template <int D> void scatter_gradient(int batch, const BatchDerivatives& in, double beta, double* gradient) const;
  /// Returns how many elements of the batch were changed.
  int project_batch(int batch, const Stage& stage, Projection projection, double* hessian) const;
  template <int D> void scatter_hessian(int batch, const BatchDerivatives& in, double scale, double* values) const;

  ElementGroup m_group;
  Isa m_isa;
  ElementKernel m_kernel;
  ProjectElements m_project; ///< of classic models
  std::vector<RestPlace> m_rest_places;
  RestCurvature m_rest_curvature;
  double m_rest_curvature_time = 0.0;
  bool m_rest_curvature_known = false;
  bool m_rest_curvature_moves = true;
  const Threads& m_threads;
  const Quaternions* m_rotations = nullptr;
  const DofLayout* m_layout = nullptr;
  InertiaShares m_inertia;
  std::vector<Chunk> m_chunks;
  std::vector<std::vector<int>> m_colours;   ///< chunk numbers
  std::vector<std::int32_t> m_block_numbers; ///< batch-major, 10 per element, lanes innermost
  int m_section = 0;
};

} // namespace wry::fem
