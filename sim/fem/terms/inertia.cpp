#include "sim/fem/terms/node_terms.h"

namespace wry::fem {

namespace {

/// Inertia of one kind of unknown: velocities, or angular velocities.
class Inertia : public EnergyTerm {
public:
  Inertia(const FemModel& model, const std::vector<double>& mass, int dof_offset)
      : m_model(model)
      , m_mass(mass)
      , m_offset(dof_offset) {}

  bool acts_on_increments() const override { return false; }

  double energy(const Stage& stage, const Trial& trial) const override {
    double sum = 0.0;
    for (int node = 0; node < m_model.layout.node_count(); ++node) {
      if (m_mass[node] > 0.0)
        sum += 0.5 * m_mass[node] * (unknown(trial).row(node) - base(stage).row(node)).squaredNorm();
    }
    return sum;
  }

  double add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const override {
    double sum = 0.0;
    for (int node = 0; node < m_model.layout.node_count(); ++node) {
      if (m_mass[node] <= 0.0)
        continue;
      const Vec3 change = unknown(trial).row(node) - base(stage).row(node);
      sum += 0.5 * m_mass[node] * change.squaredNorm();
      Eigen::Map<Vec3>(gradient.data() + m_model.layout.dof(node) + m_offset) += m_mass[node] * change;
    }
    return sum;
  }

  int add_hessian(const Stage&, const Trial&, Projection, BlockMatrix& matrix) const override {
    for (BlockMatrix::Section& section : matrix.sections()) {
      const int d = section.nodes.dofs;
      if (m_offset >= d)
        continue;
      for (int node = 0; node < section.nodes.node_count; ++node) {
        double* block = section.values.data() + section.row_begin[node] * d * d;
        for (int i = m_offset; i < m_offset + 3; ++i)
          block[i * d + i] += m_mass[section.nodes.first_node + node];
      }
    }
    return 0;
  }

protected:
  virtual const Points& unknown(const Trial& trial) const = 0;
  virtual const Points& base(const Stage& stage) const = 0;

private:
  const FemModel& m_model;
  const std::vector<double>& m_mass;
  int m_offset;
};

class LinearInertia final : public Inertia {
public:
  explicit LinearInertia(const FemModel& model)
      : Inertia(model, model.mass, 0) {}
  std::string_view name() const override { return "inertia"; }

protected:
  const Points& unknown(const Trial& trial) const override { return trial.velocities; }
  const Points& base(const Stage& stage) const override { return stage.base_velocities; }
};

class RotaryInertia final : public Inertia {
public:
  explicit RotaryInertia(const FemModel& model)
      : Inertia(model, model.rotary_mass, 3) {}
  std::string_view name() const override { return "rotary_inertia"; }

protected:
  const Points& unknown(const Trial& trial) const override { return trial.angular; }
  const Points& base(const Stage& stage) const override { return stage.base_angular; }
};

} // namespace

std::unique_ptr<EnergyTerm> make_inertia(const FemModel& model, const ContactState&) {
  return std::make_unique<LinearInertia>(model);
}

std::unique_ptr<EnergyTerm> make_rotary_inertia(const FemModel& model, const ContactState&) {
  if (!model.any_rotary)
    return nullptr;
  return std::make_unique<RotaryInertia>(model);
}

} // namespace wry::fem
