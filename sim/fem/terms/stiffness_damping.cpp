#include "sim/fem/terms/stiffness_damping.h"

#include <cmath>

#include "sim/fem/newton.h"

namespace wry::fem {

namespace {

class StiffnessDamping final : public EnergyTerm {
public:
  StiffnessDamping(const FemModel& model, std::vector<DampedElements> damped, std::unique_ptr<BlockMatrix> matrix,
                   const Threads& threads)
      : m_model(model)
      , m_damped(std::move(damped))
      , m_matrix(std::move(matrix))
      , m_threads(threads) {}

  std::string_view name() const override { return "stiffness_damping"; }

  bool acts_on_increments() const override { return false; }

  void begin_solve(const Stage& stage, const Trial& trial) override {
    m_matrix->set_zero(m_threads);
    // Where the step ends if nothing hinders it: from its start alone, damping would be off by the length of the step.
    Trial expected = trial;
    update_trial(stage, expected);
    for (const DampedElements& body : m_damped) {
      if (!std::isfinite(body.elements->energy(stage, expected))) {
        expected.positions = stage.start_positions;
        expected.increments.setZero();
      }
      Stage scaled;
      scaled.beta = std::sqrt(body.damping);
      scaled.time = stage.time;
      body.elements->add_hessian(scaled, expected, Projection::elements, *m_matrix);
    }
  }

  double energy(const Stage& stage, const Trial& trial) const override { return 0.5 * stage.beta * multiply(trial); }

  double add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const override {
    const double work = multiply(trial);
    unpad(m_model.layout, m_product, m_packed);
    for (std::size_t i = 0; i < gradient.size(); ++i)
      gradient[i] += stage.beta * m_packed[i];
    return 0.5 * stage.beta * work;
  }

  int add_hessian(const Stage& stage, const Trial&, Projection, BlockMatrix& matrix) const override {
    for (std::size_t s = 0; s < matrix.sections().size(); ++s) {
      AlignedVector<double>& out = matrix.sections()[s].values;
      const AlignedVector<double>& in = m_matrix->sections()[s].values;
      m_threads.for_chunks(out.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
          out[i] += stage.beta * in[i];
      });
    }
    return 0;
  }

private:
  /// m_product <- C u; returns u . C u.
  double multiply(const Trial& trial) const {
    const DofLayout& layout = m_model.layout;
    m_packed.resize(layout.dof_count());
    for (int node = 0; node < layout.node_count(); ++node) {
      double* out = m_packed.data() + layout.dof(node);
      Eigen::Map<Vec3>(out, 3) = trial.velocities.row(node).transpose();
      if (layout.dofs(node) == 6)
        Eigen::Map<Vec3>(out + 3, 3) = trial.angular.row(node).transpose();
    }
    pad(layout, m_packed, m_unknowns);
    m_product.resize(layout.padded_count());
    return m_matrix->multiply(m_unknowns, m_product, m_threads);
  }

  const FemModel& m_model;
  std::vector<DampedElements> m_damped;
  std::unique_ptr<BlockMatrix> m_matrix;
  const Threads& m_threads;
  mutable std::vector<double> m_packed;
  mutable AlignedVector<double> m_unknowns, m_product;
};

} // namespace

std::unique_ptr<EnergyTerm> make_stiffness_damping(const FemModel& model, std::vector<DampedElements> damped,
                                                   std::unique_ptr<BlockMatrix> matrix, const Threads& threads) {
  return std::make_unique<StiffnessDamping>(model, std::move(damped), std::move(matrix), threads);
}

} // namespace wry::fem
