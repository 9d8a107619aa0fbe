#include "sim/fem/terms/node_terms.h"

namespace wry::fem {

namespace {

/// - beta v . f and - a . m of given forces and torques. A torque has no potential; this one is right to first order in
/// the increment, which methods of second order keep small.
class Loads final : public EnergyTerm {
public:
  explicit Loads(const FemModel& model)
      : m_model(model) {}

  std::string_view name() const override { return "loads"; }

  void begin_solve(const Stage& stage, const Trial&) override {
    m_pushes.clear();
    for (const NodeLoad& load : m_model.loads) {
      const Vec3 force = load.force ? load.force(stage.time) : Vec3(Vec3::Zero());
      const Vec3 torque = load.torque ? load.torque(stage.time) : Vec3(Vec3::Zero());
      for (std::size_t i = 0; i < load.nodes.size(); ++i)
        m_pushes.push_back({load.nodes[i], load.shares[i] * force, load.shares[i] * torque});
    }
  }

  double energy(const Stage& stage, const Trial& trial) const override {
    double sum = 0.0;
    for (const Push& push : m_pushes) {
      sum -= stage.beta * trial.velocities.row(push.node).dot(push.force);
      if (m_model.layout.dofs(push.node) == 6)
        sum -= trial.increments.row(push.node).dot(push.torque);
    }
    return sum;
  }

  double add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const override {
    for (const Push& push : m_pushes) {
      double* out = gradient.data() + m_model.layout.dof(push.node);
      Eigen::Map<Vec3>(out, 3) -= stage.beta * push.force;
      if (m_model.layout.dofs(push.node) == 6)
        Eigen::Map<Vec3>(out + 3, 3) -= stage.beta * push.torque;
    }
    return energy(stage, trial);
  }

  int add_hessian(const Stage&, const Trial&, Projection, BlockMatrix&) const override { return 0; }

private:
  struct Push {
    int node = 0;
    Vec3 force, torque; ///< [N], [N m]
  };

  const FemModel& m_model;
  std::vector<Push> m_pushes;
};

} // namespace

std::unique_ptr<EnergyTerm> make_loads(const FemModel& model, const ContactState&) {
  if (model.loads.empty())
    return nullptr;
  return std::make_unique<Loads>(model);
}

} // namespace wry::fem
