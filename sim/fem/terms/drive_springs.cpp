#include <cmath>

#include "sim/base/rotation.h"
#include "sim/fem/terms/node_terms.h"

namespace wry::fem {

namespace {

/// A penalty's share of the mass over beta^2, as of the stiffness around the node.
constexpr double PENALTY = 1e4;

/// k/2 |x - x'|^2 and c (1 - cos theta), theta the angle between the microrotation and that of the motion.
class DriveSpringTerm final : public EnergyTerm {
public:
  explicit DriveSpringTerm(const FemModel& model)
      : m_model(model) {}

  std::string_view name() const override { return "drive_springs"; }

  void begin_solve(const Stage& stage, const Trial&) override {
    m_pulls.clear();
    const DriveSprings& springs = m_model.springs;
    m_poses.clear();
    for (const scene::Motion& motion : springs.motions)
      m_poses.push_back(motion.pose(stage.time));
    for (const DriveSpring& spring : springs.nodes) {
      if (stage.time > springs.until[spring.motion] * (1.0 + 1e-12))
        continue;
      const scene::Pose& pose = m_poses[spring.motion];
      Pull pull{spring.node, pose.apply(spring.rest), spring.stiffness, spring.turning, pose.rotation};
      const double per_square = spring.scales_with_mass ? PENALTY / (stage.beta * stage.beta) : 0.0;
      if (spring.stiffness > 0.0)
        pull.stiffness += per_square * m_model.mass[spring.node];
      if (spring.turning > 0.0)
        pull.turning += per_square * m_model.rotary_mass[spring.node];
      m_pulls.push_back(pull);
    }
  }

  double energy(const Stage&, const Trial& trial) const override {
    double sum = 0.0;
    for (const Pull& pull : m_pulls) {
      sum += 0.5 * pull.stiffness * (trial.positions.row(pull.node).transpose() - pull.target).squaredNorm();
      if (pull.turning > 0.0)
        sum += turning_energy(pull, relative(pull, trial));
    }
    return sum;
  }

  double add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const override {
    double sum = 0.0;
    for (const Pull& pull : m_pulls) {
      double* out = gradient.data() + m_model.layout.dof(pull.node);
      const Vec3 way = trial.positions.row(pull.node).transpose() - pull.target;
      sum += 0.5 * pull.stiffness * way.squaredNorm();
      Eigen::Map<Vec3>(out) += stage.beta * pull.stiffness * way;
      if (pull.turning > 0.0) {
        const Turn turn = relative(pull, trial);
        sum += turning_energy(pull, turn);
        Eigen::Map<Vec3>(out + 3) += stage.beta * (turn.D.transpose() * torque(pull, turn));
      }
    }
    return sum;
  }

  int add_hessian(const Stage& stage, const Trial& trial, Projection projection, BlockMatrix& matrix) const override {
    const double scale = stage.beta * stage.beta;
    for (const Pull& pull : m_pulls) {
      const Mat3 block = scale * pull.stiffness * Mat3::Identity();
      matrix.add_velocity_diagonal(pull.node, block.data());
      if (pull.turning == 0.0)
        continue;
      const Turn turn = relative(pull, trial);
      // The second derivative along turns (spec §1): D^T K D - (a tau^T + tau a^T) / (4 n^2).
      const Mat3 K = 0.5 * pull.turning * (turn.Q.trace() * Mat3::Identity() - 0.5 * (turn.Q + turn.Q.transpose()));
      Mat3 second = turn.D.transpose() * K * turn.D;
      if (!is_of_elements(projection)) {
        const Vec3 tau = turn.D.transpose() * torque(pull, turn);
        second -= (turn.a * tau.transpose() + tau * turn.a.transpose()) / (4.0 + turn.a.squaredNorm());
      }
      const Mat3 turning = scale * second;
      matrix.add_angular_diagonal(pull.node, turning.data());
    }
    return 0;
  }

private:
  struct Pull {
    int node = 0;
    Vec3 target = Vec3::Zero();
    double stiffness = 0.0, turning = 0.0;
    Mat3 rotation = Mat3::Identity();
  };
  /// The microrotation relative to the motion's, and how it varies with the increment.
  struct Turn {
    Vec3 a;
    Mat3 D, Q;
  };

  Turn relative(const Pull& pull, const Trial& trial) const {
    Turn turn;
    turn.a = trial.increments.row(pull.node);
    turn.D = (Mat3::Identity() + 0.5 * cross_matrix(turn.a)) / (1.0 + 0.25 * turn.a.squaredNorm());
    const Vec4 q = cayley_update(Vec4(m_model.rotations->row(pull.node)), turn.a);
    turn.Q = rotation_matrix(q) * pull.rotation.transpose();
    return turn;
  }

  /// 1 - cos theta = |Q - I|^2 / 4, without cancellation.
  static double turning_energy(const Pull& pull, const Turn& turn) {
    return 0.25 * pull.turning * (turn.Q - Mat3::Identity()).squaredNorm();
  }

  /// dE/d theta = c axl skew Q.
  static Vec3 torque(const Pull& pull, const Turn& turn) {
    const Mat3& Q = turn.Q;
    return 0.5 * pull.turning * Vec3(Q(2, 1) - Q(1, 2), Q(0, 2) - Q(2, 0), Q(1, 0) - Q(0, 1));
  }

  const FemModel& m_model;
  std::vector<scene::Pose> m_poses;
  std::vector<Pull> m_pulls;
};

} // namespace

std::unique_ptr<EnergyTerm> make_drive_springs(const FemModel& model, const ContactState&) {
  if (model.springs.nodes.empty())
    return nullptr;
  return std::make_unique<DriveSpringTerm>(model);
}

} // namespace wry::fem
