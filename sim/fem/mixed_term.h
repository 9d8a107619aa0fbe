#pragma once

#include <functional>

#include "sim/fem/body_elements.h"
#include "sim/fem/inertia_shares.h"
#include "sim/fem/mixed_group.h"

namespace wry::fem {

/// The strain energy of one body's quadratic tets, plates or one-point tets. As ElementTerm, with more nodes: all nodes
/// have six unknowns, of which midpoints use the first three.
class MixedTerm final : public BodyElements {
public:
  /// `rest_places`: NP per element, for the rest curvature (may be empty).
  MixedTerm(MixedGroup group, std::vector<RestPlace> rest_places, RestCurvature rest_curvature, const Threads& threads);

  std::string_view name() const override { return "elements"; }
  int element_count() const override { return m_group.element_count; }
  double element_volume(int element) const override { return m_group.volume[static_cast<std::size_t>(element)]; }
  std::vector<std::array<std::int32_t, 4>> node_quadruples() const override;
  bool has_curvature() const override { return m_group.curvature != MixedCurvature::none; }
  std::span<double> point_rotations() override { return m_group.point_rotations; }
  void bind_rotations(const Quaternions* rotations) override { m_rotations = rotations; }
  void bind_model(const FemModel& model, const BlockMatrix& matrix) override;
  void update_rest_curvature(double time) override;
  void freeze_rest_curvature() override { m_rest_curvature_moves = false; }

  void begin_solve(const Stage& stage, const Trial& trial) override;
  double energy(const Stage& stage, const Trial& trial) const override;
  double add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const override;
  int add_hessian(const Stage& stage, const Trial& trial, Projection projection, BlockMatrix& matrix) const override;

  void advance_rotations(const Trial& trial) override;
  std::vector<double> element_energies(const Trial& trial) const override;
  double elastic_energy(const Trial& trial) override;
  std::vector<double> elastic_energies(const Trial& trial) override;
  void add_deformations(const Points&, std::vector<Mat3>&) const override {} // they carry microrotations
  std::size_t memory_bytes() const override;

private:
  /// Where a 6 x 6 block of two nodes of an element stands, and whether it is the transposed one.
  struct Place {
    std::int32_t block = 0;
    bool swapped = false;
  };

  void colour_batches();
  NodeFields fields_of(const Trial& trial) const;
  int lanes_of(int batch) const;
  int pair_count() const { return m_group.kernel->nodes * (m_group.kernel->nodes + 1) / 2; }
  void for_each_batch(const std::function<void(int batch)>& body) const;
  void scatter_gradient(int batch, const MixedDerivatives& in, double beta, double* gradient) const;
  void scatter_hessian(int batch, const MixedDerivatives& in, double scale, double* values) const;

  MixedGroup m_group;
  std::vector<RestPlace> m_rest_places;
  bool m_rest_curvature_moves = true;
  RestCurvature m_rest_curvature;
  double m_rest_curvature_time = 0.0;
  bool m_rest_curvature_known = false;
  const Threads& m_threads;
  const Quaternions* m_rotations = nullptr;
  const DofLayout* m_layout = nullptr;
  InertiaShares m_inertia;
  std::vector<std::vector<int>> m_colours; ///< batches that share no node
  std::vector<Place> m_places;             ///< per element and pair of its nodes
  int m_section = 0;
};

/// Clamps the eigenvalues of one lane's element Hessian to be not negative. Returns whether it had to.
bool project_mixed(const MixedKernel& kernel, MixedDerivatives& derivatives, int lane, std::span<const double> inertia);

} // namespace wry::fem
