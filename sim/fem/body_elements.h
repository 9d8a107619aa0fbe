#pragma once

#include <array>
#include <span>
#include <vector>

#include "sim/fem/element_kernels.h"
#include "sim/fem/fem_plan.h"
#include "sim/fem/terms/energy_term.h"

namespace wry::fem {

/// The strain energy of one body, whatever its elements are.
class BodyElements : public EnergyTerm {
public:
  virtual int element_count() const = 0;
  /// Rest volume; of plates, area times thickness [m^3].
  virtual double element_volume(int element) const = 0;
  /// Nodes that share an element, ascending, four at a time (the last may be repeated): every pair of nodes of an
  /// element is in one of its quadruples.
  virtual std::vector<std::array<std::int32_t, 4>> node_quadruples() const = 0;
  virtual bool has_curvature() const = 0;
  /// The rotations that the quadrature points carry, part of the state; empty for classic models.
  virtual std::span<double> point_rotations() = 0;

  /// The nodes' stored rotations, which the owner keeps in place; unused by classic models.
  virtual void bind_rotations(const Quaternions* rotations) = 0;
  /// Where the unknowns of nodes stand and what nodes weigh; must be called once before derivatives.
  virtual void bind_model(const FemModel& model, const BlockMatrix& matrix) = 0;
  /// The batches of linear tets with the full quadrature; nullptr: the elements are of another kind.
  virtual const ElementGroup* tet_group() const { return nullptr; }
  /// Makes the rotations of the quadrature points anew from those of the nodes; only of linear tets.
  virtual void reset_point_rotations(PointRotations) {}
  /// Says that the rest curvature is the same at all times.
  virtual void freeze_rest_curvature() = 0;
  /// Evaluates the rest curvature at a time.
  virtual void update_rest_curvature(double time) = 0;
  /// After convergence: turns the rotations that the quadrature points carry.
  virtual void advance_rotations(const Trial& trial) = 0;
  /// Energy of each element [J].
  virtual std::vector<double> element_energies(const Trial& trial) const = 0;
  /// Energy without its curvature part [J].
  virtual double elastic_energy(const Trial& trial) = 0;
  /// The same per element [J].
  virtual std::vector<double> elastic_energies(const Trial& trial) = 0;
  /// Adds volume x F of each element to its nodes: where there are no microrotations, their rotation is read from it.
  virtual void add_deformations(const Points& positions, std::vector<Mat3>& sums) const = 0;
  virtual std::size_t memory_bytes() const = 0;
};

} // namespace wry::fem
