#include "sim/fem/terms/node_terms.h"

namespace wry::fem {

namespace {

/// beta/2 c m |v|^2 per node, and the same of the microrotations with their inertia: a force of -c times the momentum.
class MassDamping final : public EnergyTerm {
public:
  explicit MassDamping(const FemModel& model)
      : m_model(model) {}

  std::string_view name() const override { return "mass_damping"; }

  bool acts_on_increments() const override { return false; }

  double energy(const Stage& stage, const Trial& trial) const override {
    double sum = 0.0;
    for (int node = 0; node < m_model.layout.node_count(); ++node) {
      double squares = m_model.mass[node] * trial.velocities.row(node).squaredNorm();
      if (m_model.rotary_mass[node] > 0.0)
        squares += m_model.rotary_mass[node] * trial.angular.row(node).squaredNorm();
      sum += 0.5 * stage.beta * m_model.damping[node] * squares;
    }
    return sum;
  }

  double add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const override {
    for (int node = 0; node < m_model.layout.node_count(); ++node) {
      double* out = gradient.data() + m_model.layout.dof(node);
      const double scale = stage.beta * m_model.damping[node];
      Eigen::Map<Vec3>(out) += scale * m_model.mass[node] * trial.velocities.row(node).transpose();
      if (m_model.rotary_mass[node] > 0.0)
        Eigen::Map<Vec3>(out + 3) += scale * m_model.rotary_mass[node] * trial.angular.row(node).transpose();
    }
    return energy(stage, trial);
  }

  int add_hessian(const Stage& stage, const Trial&, Projection, BlockMatrix& matrix) const override {
    for (BlockMatrix::Section& section : matrix.sections()) {
      const int d = section.nodes.dofs;
      for (int row = 0; row < section.nodes.node_count; ++row) {
        const int node = section.nodes.first_node + row;
        double* block = section.values.data() + section.row_begin[row] * d * d;
        for (int i = 0; i < d; ++i)
          block[i * d + i] +=
              stage.beta * m_model.damping[node] * (i < 3 ? m_model.mass[node] : m_model.rotary_mass[node]);
      }
    }
    return 0;
  }

private:
  const FemModel& m_model;
};

} // namespace

std::unique_ptr<EnergyTerm> make_mass_damping(const FemModel& model, const ContactState&) {
  if (model.damping.empty())
    return nullptr;
  return std::make_unique<MassDamping>(model);
}

} // namespace wry::fem
