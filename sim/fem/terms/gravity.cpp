#include "sim/fem/terms/node_terms.h"

namespace wry::fem {

namespace {

class Gravity final : public EnergyTerm {
public:
  explicit Gravity(const FemModel& model)
      : m_model(model) {}

  std::string_view name() const override { return "gravity"; }

  double energy(const Stage& stage, const Trial& trial) const override {
    double sum = 0.0;
    for (int node = 0; node < m_model.layout.node_count(); ++node)
      sum -= m_model.mass[node] * trial.velocities.row(node).dot(m_model.gravity);
    return stage.beta * sum;
  }

  double add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const override {
    for (int node = 0; node < m_model.layout.node_count(); ++node)
      Eigen::Map<Vec3>(gradient.data() + m_model.layout.dof(node)) -=
          (stage.beta * m_model.mass[node]) * m_model.gravity;
    return energy(stage, trial);
  }

  int add_hessian(const Stage&, const Trial&, Projection, BlockMatrix&) const override { return 0; }

private:
  const FemModel& m_model;
};

} // namespace

std::unique_ptr<EnergyTerm> make_gravity(const FemModel& model, const ContactState&) {
  if (model.gravity.isZero(0.0))
    return nullptr;
  return std::make_unique<Gravity>(model);
}

} // namespace wry::fem
