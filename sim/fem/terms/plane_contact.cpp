#include <cmath>
#include <limits>

#include "sim/fem/terms/barrier.h"
#include "sim/fem/terms/node_terms.h"
#include "sim/fem/terms/slip.h"

namespace wry::fem {

namespace {

/// A step may use this share of a gap: the rest keeps the barrier finite.
constexpr double GAP_SHARE = 0.9;

/// Calls body(node, plane, gap) for each pair closer than d-hat, in a fixed order.
template <class Body>
void for_each_contact(const FemModel& model, const ContactState& contact, const Points& positions, const Body& body) {
  for (const scene::PlaneCollider& plane : model.planes) {
    for (int node = 0; node < model.layout.node_count(); ++node) {
      if (contact.ignored[node])
        continue;
      const double gap = plane_gap(model, plane, positions, node);
      if (gap < contact.distance)
        body(node, plane, gap);
    }
  }
}

class PlaneBarrier final : public EnergyTerm {
public:
  PlaneBarrier(const FemModel& model, const ContactState& contact)
      : m_model(model)
      , m_contact(contact) {}

  std::string_view name() const override { return "plane_barrier"; }

  double energy(const Stage&, const Trial& trial) const override {
    double sum = 0.0;
    visit(trial, [&](int, const scene::PlaneCollider&, const Barrier& barrier) { sum += barrier.value; });
    return sum;
  }

  double add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const override {
    double sum = 0.0;
    visit(trial, [&](int node, const scene::PlaneCollider& plane, const Barrier& barrier) {
      sum += barrier.value;
      Eigen::Map<Vec3>(gradient.data() + m_model.layout.dof(node)) += (stage.beta * barrier.slope) * plane.normal;
    });
    return sum;
  }

  int add_hessian(const Stage& stage, const Trial& trial, Projection, BlockMatrix& matrix) const override {
    visit(trial, [&](int node, const scene::PlaneCollider& plane, const Barrier& barrier) {
      const Mat3 block = (stage.beta * stage.beta * barrier.second) * (plane.normal * plane.normal.transpose());
      matrix.add_velocity_diagonal(node, block.data());
    });
    return 0;
  }

  /// Exact: gaps to planes are linear along a step.
  double step_limit(const Trial& trial, const Points& change) const override {
    double limit = 1.0;
    for (const scene::PlaneCollider& plane : m_model.planes) {
      for (int node = 0; node < m_model.layout.node_count(); ++node) {
        if (m_contact.ignored[node])
          continue;
        const double approach = -plane.normal.dot(change.row(node));
        if (approach > 0.0)
          limit = std::min(limit, GAP_SHARE * plane_gap(m_model, plane, trial.positions, node) / approach);
      }
    }
    return limit;
  }

private:
  template <class Body> void visit(const Trial& trial, const Body& body) const {
    for_each_contact(m_model, m_contact, trial.positions, [&](int node, const scene::PlaneCollider& plane, double gap) {
      body(node, plane, evaluate_barrier(gap, m_contact.distance, m_contact.stiffness[m_model.body_of_node[node]]));
    });
  }

  const FemModel& m_model;
  const ContactState& m_contact;
};

/// D = mu lambda f0(|slip|), slip the tangential way of a node in the step; lambda from the state that begin_solve saw.
class PlaneFriction final : public EnergyTerm {
public:
  PlaneFriction(const FemModel& model, const ContactState& contact)
      : m_model(model)
      , m_contact(contact) {}

  std::string_view name() const override { return "plane_friction"; }

  void begin_solve(const Stage&, const Trial& trial) override {
    m_sliders.clear();
    for_each_contact(m_model, m_contact, trial.positions, [&](int node, const scene::PlaneCollider& plane, double gap) {
      const double stiffness = m_contact.stiffness[m_model.body_of_node[node]];
      const double force = -evaluate_barrier(gap, m_contact.distance, stiffness).slope;
      if (plane.friction > 0.0 && force > 0.0)
        m_sliders.push_back({node, plane.friction * force, plane.normal});
    });
  }

  void bound_friction(bool on) override { m_slip_hessian = on ? SlipHessian::bounded : SlipHessian::exact; }

  double energy(const Stage& stage, const Trial& trial) const override {
    double sum = 0.0;
    for (const Slider& slider : m_sliders)
      sum += slider.limit * evaluate_slip(slip_of(slider, stage, trial).norm(), smoothing(stage)).value;
    return sum;
  }

  double add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const override {
    double sum = 0.0;
    for (const Slider& slider : m_sliders) {
      const Vec3 slip = slip_of(slider, stage, trial);
      const SmoothedSlip smoothed = evaluate_slip(slip.norm(), smoothing(stage));
      sum += slider.limit * smoothed.value;
      Eigen::Map<Vec3>(gradient.data() + m_model.layout.dof(slider.node)) +=
          (stage.beta * slider.limit * smoothed.slope_over_slip) * slip;
    }
    return sum;
  }

  int add_hessian(const Stage& stage, const Trial& trial, Projection, BlockMatrix& matrix) const override {
    for (const Slider& slider : m_sliders) {
      Mat3 block = slip_hessian(slip_of(slider, stage, trial), slider.normal, smoothing(stage), m_slip_hessian);
      block *= stage.beta * stage.beta * slider.limit;
      matrix.add_velocity_diagonal(slider.node, block.data());
    }
    return 0;
  }

private:
  struct Slider {
    int node = 0;
    double limit = 0.0; ///< mu lambda [N]
    Vec3 normal = Vec3::UnitY();
  };

  double smoothing(const Stage& stage) const { return m_model.friction_velocity * stage.dt; }

  static Vec3 slip_of(const Slider& slider, const Stage& stage, const Trial& trial) {
    const Vec3 way = trial.positions.row(slider.node) - stage.start_positions.row(slider.node);
    return way - slider.normal.dot(way) * slider.normal;
  }

  const FemModel& m_model;
  const ContactState& m_contact;
  std::vector<Slider> m_sliders;
  SlipHessian m_slip_hessian = SlipHessian::exact;
};

} // namespace

std::unique_ptr<EnergyTerm> make_plane_barrier(const FemModel& model, const ContactState& contact) {
  if (model.planes.empty())
    return nullptr;
  return std::make_unique<PlaneBarrier>(model, contact);
}

std::unique_ptr<EnergyTerm> make_plane_friction(const FemModel& model, const ContactState& contact) {
  for (const scene::PlaneCollider& plane : model.planes) {
    if (plane.friction > 0.0)
      return std::make_unique<PlaneFriction>(model, contact);
  }
  return nullptr;
}

double plane_gap(const FemModel& model, const scene::PlaneCollider& plane, const Points& positions, int node) {
  const double thickness = model.half_thickness.empty() ? 0.0 : model.half_thickness[static_cast<std::size_t>(node)];
  return plane.normal.dot(positions.row(node).transpose() - plane.point) - thickness;
}

PlaneGaps measure_plane_gaps(const FemModel& model, const ContactState& contact, const Points& positions, int body) {
  PlaneGaps gaps;
  gaps.least = std::numeric_limits<double>::infinity();
  for (const scene::PlaneCollider& plane : model.planes) {
    for (int node = 0; node < model.layout.node_count(); ++node) {
      if (contact.ignored[node] || (body >= 0 && model.body_of_node[node] != body))
        continue;
      const double gap = plane_gap(model, plane, positions, node);
      gaps.least = std::min(gaps.least, gap);
      gaps.active += gap < contact.distance ? 1 : 0;
    }
  }
  return gaps;
}

} // namespace wry::fem
