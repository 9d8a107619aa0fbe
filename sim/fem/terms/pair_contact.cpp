#include <array>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "sim/fem/contact_system.h"
#include "sim/fem/terms/barrier.h"
#include "sim/fem/terms/node_terms.h"
#include "sim/fem/terms/slip.h"

namespace wry::fem {

namespace {

using contact::Gradient;
using contact::Hessian;
using contact::Mollifier;
using contact::PairDistance;
using contact::PairPoints;

constexpr std::size_t GRAIN = 256;
/// Pairs whose second derivatives are projected together: each takes tens of microseconds, those that are settled a
/// few.
constexpr std::size_t PROJECTION_GRAIN = 8;
/// Pairs that moved by less than this share of their distance since the last Hessian keep theirs as it is.
constexpr double SETTLED_SHARE = 0.2;

/// Adds a pair's derivative by positions to the gradient.
void scatter(const ContactSystem& system, const DofLayout& layout, const ContactPair& pair, const Gradient& derivative,
             double scale, std::vector<double>& gradient) {
  for (int k = 0; k < 4; ++k) {
    const std::int32_t node = pair.nodes[static_cast<std::size_t>(k)];
    if (system.is_unknown(node))
      Eigen::Map<Vec3>(gradient.data() + layout.dof(node)) += scale * derivative.segment<3>(3 * k);
  }
}

void scatter(const ContactSystem& system, const ContactPair& pair, const Hessian& derivative, double scale,
             BlockMatrix& matrix) {
  using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  for (int k = 0; k < 4; ++k) {
    const std::int32_t row = pair.nodes[static_cast<std::size_t>(k)];
    if (!system.is_unknown(row))
      continue;
    const Block own = scale * derivative.block<3, 3>(3 * k, 3 * k);
    matrix.add_velocity_diagonal(row, own.data());
    for (int l = k + 1; l < 4; ++l) {
      const std::int32_t column = pair.nodes[static_cast<std::size_t>(l)];
      if (!system.is_unknown(column))
        continue;
      const Block block = scale * derivative.block<3, 3>(3 * k, 3 * l);
      matrix.add_velocity_pair(row, column, block.data());
    }
  }
}

/// b'' d'd'^T + b' d'', exact or with its negative eigenvalues cut off. It lives on the span of w x n, w x t1, w x t2
/// and w_i' x n (w the weights, n the normal, t tangents), at most 5 directions, in which the eigenvalues are found.
Hessian distance_barrier_hessian(const PairDistance& pair, const Barrier& barrier, Projection projection) {
  if (projection == Projection::none) {
    const Gradient slope = contact::distance_gradient(pair);
    return barrier.second * slope * slope.transpose() + barrier.slope * contact::distance_hessian(pair);
  }
  std::array<Vec4, 3> q; // orthonormal: weights, then slopes
  const double length = pair.weights.norm();
  q[0] = pair.weights / length;
  int count = 1;
  for (int i = 0; i < pair.parameters; ++i) {
    Vec4 rest = pair.slopes[static_cast<std::size_t>(i)];
    for (int j = 0; j < count; ++j)
      rest -= rest.dot(q[static_cast<std::size_t>(j)]) * q[static_cast<std::size_t>(j)];
    q[static_cast<std::size_t>(count++)] = rest.normalized();
  }
  const Vec3 first = pair.normal.unitOrthogonal();
  const Vec3 second = pair.normal.cross(first);
  using Small = Eigen::Matrix<double, 5, 5>;
  using SmallVector = Eigen::Matrix<double, 5, 1>;
  const double per_distance = barrier.slope / pair.distance;
  Small core = Small::Zero();
  core(0, 0) = barrier.second * length * length;
  core(1, 1) = core(2, 2) = per_distance * length * length;
  std::array<SmallVector, 2> mixed;
  for (int i = 0; i < pair.parameters; ++i) {
    const Vec4& slope = pair.slopes[static_cast<std::size_t>(i)];
    const Vec3& direction = pair.directions[static_cast<std::size_t>(i)];
    SmallVector& m = mixed[static_cast<std::size_t>(i)];
    m << pair.distance * slope.dot(q[0]), length * direction.dot(first), length * direction.dot(second), 0.0, 0.0;
    for (int j = 1; j < count; ++j)
      m[2 + j] = pair.distance * slope.dot(q[static_cast<std::size_t>(j)]);
  }
  for (int i = 0; i < pair.parameters; ++i) {
    for (int j = 0; j < pair.parameters; ++j)
      core.noalias() -= (per_distance * pair.inverse_metric(i, j)) * mixed[static_cast<std::size_t>(i)] *
                        mixed[static_cast<std::size_t>(j)].transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Small> eigen(core);
  Hessian hessian = Hessian::Zero();
  for (int e = 0; e < 5; ++e) {
    const double value = eigen.eigenvalues()[e];
    if (value <= 0.0)
      continue;
    const SmallVector v = eigen.eigenvectors().col(e);
    Gradient full;
    for (int k = 0; k < 4; ++k) {
      double along = v[0] * q[0][k];
      for (int j = 1; j < count; ++j)
        along += v[2 + j] * q[static_cast<std::size_t>(j)][k];
      full.segment<3>(3 * k) = along * pair.normal + q[0][k] * (v[1] * first + v[2] * second);
    }
    hessian.noalias() += value * full * full.transpose();
  }
  return hessian;
}

Hessian clamped(const Hessian& hessian) {
  const Eigen::SelfAdjointEigenSolver<Hessian> eigen(hessian);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
}

/// The barrier of eq 19 on every near pair, times the mollifier for edges.
class PairBarrier final : public EnergyTerm {
public:
  PairBarrier(const FemModel& model, ContactSystem& system, const Threads& threads)
      : m_model(model)
      , m_system(system)
      , m_threads(threads) {}

  std::string_view name() const override { return "pair_barrier"; }

  void begin_step(const Stage& stage, const Points&) override {
    m_system.begin_step(stage.start_time, stage.time);
    m_assembled_at.resize(0, 3);
    m_settled_share = SETTLED_SHARE;
  }
  void begin_solve(const Stage& stage, const Trial& trial) override {
    m_system.expect_ways(stage.dt * trial.velocities);
  }
  double advance_prescribed(const Trial& trial) override { return m_system.advance_obstacles(trial.positions); }

  double energy(const Stage&, const Trial& trial) const override {
    const std::vector<ContactPair>& pairs = m_system.pairs_at(trial.positions);
    return m_threads.sum_chunks(pairs.size(), GRAIN, [&](std::size_t begin, std::size_t end) {
      double sum = 0.0;
      for (std::size_t i = begin; i < end; ++i) {
        const PairPoints points = m_system.points_of(pairs[i]);
        const PairDistance pair = contact::pair_distance(pairs[i].kind, points);
        sum += mollifier_of(pairs[i], points).value * barrier_of(pairs[i], pair).value;
      }
      return sum;
    });
  }

  double add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const override {
    const std::vector<ContactPair>& pairs = m_system.pairs_at(trial.positions);
    m_gradients.resize(pairs.size());
    const double sum = m_threads.sum_chunks(pairs.size(), GRAIN, [&](std::size_t begin, std::size_t end) {
      double part = 0.0;
      for (std::size_t i = begin; i < end; ++i) {
        const PairPoints points = m_system.points_of(pairs[i]);
        const PairDistance pair = contact::pair_distance(pairs[i].kind, points);
        const Barrier barrier = barrier_of(pairs[i], pair);
        const Mollifier mollifier = mollifier_of(pairs[i], points);
        part += mollifier.value * barrier.value;
        m_gradients[i] = (mollifier.value * barrier.slope) * contact::distance_gradient(pair);
        if (mollifier.slope != 0.0)
          m_gradients[i] += (mollifier.slope * barrier.value) * contact::cross_squared_gradient(points);
      }
      return part;
    });
    for (std::size_t i = 0; i < pairs.size(); ++i)
      scatter(m_system, m_model.layout, pairs[i], m_gradients[i], stage.beta, gradient);
    return sum;
  }

  int add_hessian(const Stage& stage, const Trial& trial, Projection projection, BlockMatrix& matrix) const override {
    const std::vector<ContactPair>& pairs = m_system.pairs_at(trial.positions);
    const bool first = m_assembled_at.rows() == 0;
    if (projection != Projection::contacts) // what was left as it is may have been to blame
      m_settled_share *= 0.5;
    constexpr std::size_t RUN = 16 * GRAIN; // bounds the memory
    m_hessians.resize(std::min(pairs.size(), RUN));
    for (std::size_t start = 0; start < pairs.size(); start += RUN) {
      const std::size_t count = std::min(RUN, pairs.size() - start);
      m_threads.for_each(count, PROJECTION_GRAIN, [&](std::size_t i) {
        const ContactPair& pair = pairs[start + i];
        const bool exact = projection == Projection::contacts && !first && is_settled(pair, trial.positions);
        m_hessians[i] = hessian_of(pair, m_system.points_of(pair), exact ? Projection::none : projection);
      });
      for (std::size_t i = 0; i < count; ++i)
        scatter(m_system, pairs[start + i], m_hessians[i], stage.beta * stage.beta, matrix);
    }
    if (!pairs.empty())
      m_assembled_at = trial.positions;
    return 0;
  }

  double step_limit(const Trial& trial, const Points& change) const override {
    return m_system.step_limit(trial.positions, change);
  }

private:
  Barrier barrier_of(const ContactPair& pair, const PairDistance& distance) const {
    return evaluate_barrier(distance.distance - pair.thickness, pair.activation, m_system.stiffness(pair));
  }

  static Mollifier mollifier_of(const ContactPair& pair, const PairPoints& points) {
    if (pair.mollifier_threshold == 0.0)
      return {};
    return contact::evaluate_mollifier(contact::cross_squared(points), pair.mollifier_threshold);
  }

  /// Cutting off negative eigenvalues makes the first iterations safe and the last ones slow: Newton would close in by
  /// a constant factor only. Near the minimum the whole matrix is positive definite without; where it is not, the
  /// solver says so and asks for a projection.
  bool is_settled(const ContactPair& pair, const Points& positions) const {
    const PairPoints points = m_system.points_of(pair);
    const PairPoints way = m_system.way_of(pair, positions, m_assembled_at);
    double most = 0.0;
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b)
        most = std::max(most, (way.row(a) - way.row(b)).squaredNorm());
    }
    const double gap = std::sqrt(contact::squared_distance(pair.kind, points)) - pair.thickness;
    return std::sqrt(most) < m_settled_share * gap;
  }

  Hessian hessian_of(const ContactPair& contact, const PairPoints& points, Projection projection) const {
    const PairDistance pair = contact::pair_distance(contact.kind, points);
    const Barrier barrier = barrier_of(contact, pair);
    const Mollifier m = mollifier_of(contact, points);
    if (m.slope == 0.0)
      return m.value * distance_barrier_hessian(pair, barrier, projection);
    const Gradient d = contact::distance_gradient(pair);
    const Gradient c = contact::cross_squared_gradient(points);
    Hessian hessian = m.value * distance_barrier_hessian(pair, barrier, Projection::none);
    hessian.noalias() += (m.slope * barrier.slope) * (c * d.transpose() + d * c.transpose());
    hessian.noalias() += (m.second * barrier.value) * c * c.transpose();
    hessian += (m.slope * barrier.value) * contact::cross_squared_hessian(points);
    return projection == Projection::none ? hessian : clamped(hessian);
  }

  const FemModel& m_model;
  ContactSystem& m_system;
  const Threads& m_threads;
  mutable std::vector<Gradient> m_gradients;
  mutable std::vector<Hessian> m_hessians;
  mutable double m_settled_share = SETTLED_SHARE;
  mutable Points m_assembled_at; ///< of the step's last Hessian; without rows before the first
};

/// D = mu lambda f0(|u|) with u the tangential way of the nearest points relative to each other in the step; lambda,
/// the tangent plane and mu from the state that begin_solve saw.
class PairFriction final : public EnergyTerm {
public:
  PairFriction(const FemModel& model, ContactSystem& system)
      : m_model(model)
      , m_system(system) {}

  std::string_view name() const override { return "pair_friction"; }

  void begin_step(const Stage&, const Points&) override { m_first_pass = true; }

  void begin_solve(const Stage& stage, const Trial& trial) override {
    m_sliders.clear();
    for (const ContactPair& contact : m_system.pairs_at(trial.positions)) {
      const Friction& friction = m_system.friction(contact);
      if (friction.at_rest <= 0.0 && friction.sliding <= 0.0)
        continue;
      const PairPoints points = m_system.points_of(contact);
      const PairDistance pair = contact::pair_distance(contact.kind, points);
      double force =
          -evaluate_barrier(pair.distance - contact.thickness, contact.activation, m_system.stiffness(contact)).slope;
      if (contact.mollifier_threshold > 0.0)
        force *= contact::evaluate_mollifier(contact::cross_squared(points), contact.mollifier_threshold).value;
      Slider slider{contact, pair.weights, pair.normal, force, 0.0};
      slider.limit = force * coefficient(friction, slider, stage, trial);
      if (slider.limit > 0.0)
        m_sliders.push_back(slider);
    }
    m_first_pass = false;
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
      Gradient derivative;
      for (int k = 0; k < 4; ++k)
        derivative.segment<3>(3 * k) = (slider.limit * smoothed.slope_over_slip * slider.weights[k]) * slip;
      scatter(m_system, m_model.layout, slider.pair, derivative, stage.beta, gradient);
    }
    return sum;
  }

  int add_hessian(const Stage& stage, const Trial& trial, Projection, BlockMatrix& matrix) const override {
    for (const Slider& slider : m_sliders) {
      Mat3 block = slip_hessian(slip_of(slider, stage, trial), slider.normal, smoothing(stage), m_slip_hessian);
      block *= slider.limit;
      Hessian hessian;
      for (int k = 0; k < 4; ++k) {
        for (int l = 0; l < 4; ++l)
          hessian.block<3, 3>(3 * k, 3 * l) = (slider.weights[k] * slider.weights[l]) * block;
      }
      scatter(m_system, slider.pair, hessian, stage.beta * stage.beta, matrix);
    }
    return 0;
  }

private:
  struct Slider {
    ContactPair pair;
    Vec4 weights;
    Vec3 normal;
    double force = 0.0; ///< lambda [N]
    double limit = 0.0; ///< mu lambda [N]
  };

  double smoothing(const Stage& stage) const { return m_model.friction_velocity * stage.dt; }

  Vec3 slip_of(const Slider& slider, const Stage& stage, const Trial& trial) const {
    const PairPoints ways = m_system.way_of(slider.pair, trial.positions, stage.start_positions);
    const Vec3 way = ways.transpose() * slider.weights;
    return way - slider.normal.dot(way) * slider.normal;
  }

  /// At rest until the slip of the last step, or of this one's first solve, is faster than the friction velocity.
  double coefficient(const Friction& friction, const Slider& slider, const Stage& stage, const Trial& trial) const {
    if (friction.at_rest == friction.sliding)
      return friction.at_rest;
    Vec3 speed = slip_of(slider, stage, trial) / stage.dt;
    if (m_first_pass) { // nothing has moved yet: the velocities at the start tell
      Vec3 rate = Vec3::Zero();
      for (int k = 0; k < 4; ++k) {
        const std::int32_t node = slider.pair.nodes[static_cast<std::size_t>(k)];
        if (m_system.is_unknown(node))
          rate += slider.weights[k] * stage.base_velocities.row(node).transpose();
      }
      speed = rate - slider.normal.dot(rate) * slider.normal;
    }
    return speed.norm() <= m_model.friction_velocity ? friction.at_rest : friction.sliding;
  }

  const FemModel& m_model;
  ContactSystem& m_system;
  std::vector<Slider> m_sliders;
  SlipHessian m_slip_hessian = SlipHessian::exact;
  bool m_first_pass = true;
};

} // namespace

std::unique_ptr<EnergyTerm> make_pair_barrier(const FemModel& model, const ContactState& contact) {
  if (contact.system == nullptr)
    return nullptr;
  return std::make_unique<PairBarrier>(model, *contact.system, contact.system->threads());
}

std::unique_ptr<EnergyTerm> make_pair_friction(const FemModel& model, const ContactState& contact) {
  if (contact.system == nullptr || !contact.system->any_friction())
    return nullptr;
  return std::make_unique<PairFriction>(model, *contact.system);
}

} // namespace wry::fem
