#include "sim/fem/boundary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/base/rotation.h"
#include "sim/fem/rotation_update.h"

namespace wry::fem {

namespace {

constexpr double NEVER = std::numeric_limits<double>::infinity();
constexpr double MOST_TURN = 30.0 * std::numbers::pi / 180.0; // [rad] in a step
constexpr int SPEED_SAMPLES = 8;
constexpr double PENALTY = 1e4;

std::array<bool, 3> all(bool value) {
  return {value, value, value};
}

/// How firmly the matter around each node of a body holds it: against displacement [N/m] and against turning [N m].
struct NodeStiffness {
  std::vector<double> positions, turns;
};

NodeStiffness node_stiffness(const ElementGroup& group, int node_count) {
  NodeStiffness stiffness{std::vector<double>(node_count, 0.0), std::vector<double>(node_count, 0.0)};
  const int moduli = group.curvature == CurvatureModel::isotropic ? 3 : 9;
  for (int element = 0; element < group.element_count; ++element) {
    const std::size_t batch = element / LANES;
    const int lane = element % LANES;
    const auto entry = [&](const AlignedVector<double>& array, int count, int i) {
      return array[(batch * count + i) * LANES + lane];
    };
    Mat3 gradients;
    for (int i = 0; i < 9; ++i)
      gradients(i / 3, i % 3) = entry(group.shape_gradients, 9, i);
    const Vec3 first = -gradients.colwise().sum().transpose();
    double curvature = 0.0;
    for (int i = 0; group.curvature != CurvatureModel::none && i < moduli; ++i)
      curvature = std::max(curvature, 2.0 * entry(group.curvature_moduli, moduli, i));
    const double volume = entry(group.volume, 1, 0);
    const double stretch = entry(group.lambda, 1, 0) + 2.0 * entry(group.mu, 1, 0);
    for (int k = 0; k < 4; ++k) {
      const int node = group.nodes[(batch * 4 + k) * LANES + lane];
      const double square = k == 0 ? first.squaredNorm() : gradients.row(k - 1).squaredNorm();
      stiffness.positions[node] += volume * stretch * square;
      stiffness.turns[node] += volume * (entry(group.mu_c, 1, 0) + curvature * square);
    }
  }
  return stiffness;
}

/// The same for other elements, from the size of their edges.
NodeStiffness estimated_stiffness(const FemMaterial& material, const FemScene& scene, int body) {
  const int node_count = scene.model.layout.node_count();
  NodeStiffness stiffness{std::vector<double>(node_count, 0.0), std::vector<double>(node_count, 0.0)};
  const double nu = material.poisson_ratio;
  const double shear = material.youngs_modulus / (2.0 * (1.0 + nu));
  const double stretch = 2.0 * shear * (1.0 - nu) / (1.0 - 2.0 * nu);
  const double square = 1.0 / (scene.edges[body] * scene.edges[body]);
  const double curvature = shear * material.length_scale * material.length_scale *
                           std::max({material.alpha + material.gamma, material.alpha + material.beta,
                                     2.0 * material.curvature_stiffness.maxCoeff()});
  for (int node = 0; node < node_count; ++node) {
    const double volume = scene.model.mass[node] / material.density;
    stiffness.positions[node] = volume * stretch * square;
    stiffness.turns[node] = volume * (material.couple_modulus_ratio * shear + curvature * square);
  }
  return stiffness;
}

NodeStiffness node_stiffness(const FemPlan& plan, const FemScene& scene, int body) {
  if (const ElementGroup* group = scene.elements[body]->tet_group())
    return node_stiffness(*group, scene.model.layout.node_count());
  return estimated_stiffness(plan.bodies[body].material, scene, body);
}

} // namespace

Boundary::Boundary(const FemPlan& plan, const FemScene& scene)
    : m_layout(scene.model.layout)
    , m_rest(scene.start_positions) {
  for (const FixedNodes& fixed : plan.fixed)
    add(scene, fixed.body, fixed.nodes,
        {{}, fixed.hold_positions, fixed.axes, all(fixed.hold_microrotations), fixed.until.value_or(NEVER), -1});
  for (const DrivenNodes& driven : plan.driven) {
    if (driven.until)
      m_events.push_back(*driven.until);
    for (const double time : driven.motion.key_times())
      m_events.push_back(time);
    m_motions.push_back(driven.motion);
    if (driven.method == DriveMethod::exact)
      add(scene, driven.body, driven.nodes,
          {{},
           driven.drive_positions,
           all(true),
           driven.drive_microrotations ? driven.driven_turns : all(false),
           driven.until.value_or(NEVER),
           static_cast<int>(m_motions.size()) - 1});
  }
  for (const FixedNodes& fixed : plan.fixed) {
    if (fixed.until)
      m_events.push_back(*fixed.until);
  }
  // A vertex in no tet: nothing moves it.
  Hold loose{{}, true, all(true), all(true), NEVER, -1};
  for (int node = 0; node < m_layout.node_count(); ++node) {
    if (scene.model.mass[node] == 0.0)
      loose.nodes.push_back(node);
  }
  m_holds.push_back(std::move(loose));
  // The middles of edges have no rotation of their own.
  Hold middles{{}, false, all(true), all(true), NEVER, -1};
  for (const BodyNodes& body : scene.model.bodies) {
    for (const BodyNodes::Midpoint& middle : body.midpoints)
      middles.nodes.push_back(middle.node);
  }
  m_holds.push_back(std::move(middles));
  std::sort(m_events.begin(), m_events.end());
}

void Boundary::add(const FemScene& scene, int body, const std::vector<std::int32_t>& vertices, Hold hold) {
  hold.nodes = nodes_of(scene, body, vertices);
  m_holds.push_back(std::move(hold));
}

bool Boundary::active(const Hold& hold, double time) const {
  return time <= hold.until * (1.0 + 1e-12);
}

void Boundary::hold(double time) {
  m_held.assign(m_layout.dof_count(), 0);
  m_immovable.assign(m_layout.node_count(), 0);
  for (const Hold& hold : m_holds) {
    if (!active(hold, time))
      continue;
    for (const int node : hold.nodes) {
      const std::size_t dof = m_layout.dof(node);
      for (std::size_t i = 0; hold.positions && i < 3; ++i) {
        if (hold.axes[i])
          m_held[dof + i] = 1;
      }
      m_immovable[node] = m_held[dof] && m_held[dof + 1] && m_held[dof + 2];
      for (std::size_t i = 0; m_layout.dofs(node) == 6 && i < 3; ++i) {
        if (hold.turns[i])
          m_held[dof + 3 + i] = 1;
      }
    }
  }
}

void Boundary::impose(const Stage& stage, const Quaternions& rotations, Trial& trial) const {
  for (const Hold& hold : m_holds) {
    if (active(hold, stage.time))
      impose(hold, stage, rotations, trial);
  }
}

void Boundary::impose(const Hold& hold, const Stage& stage, const Quaternions& rotations, Trial& trial) const {
  scene::Pose pose;
  Vec4 turn = identity_quaternion();
  if (hold.motion >= 0) {
    pose = m_motions[hold.motion].pose(stage.time);
    turn = quaternion_of(pose.rotation);
  }
  for (const int node : hold.nodes) {
    if (hold.positions) {
      const Vec3 target = hold.motion >= 0 ? pose.apply(m_rest.row(node)) : Vec3(stage.start_positions.row(node));
      for (int i = 0; i < 3; ++i) {
        if (hold.axes[static_cast<std::size_t>(i)])
          trial.velocities(node, i) = (target[i] - stage.base_positions(node, i)) / stage.beta;
      }
    }
    if (hold.turns == all(false) || m_layout.dofs(node) != 6)
      continue;
    const Vec3 base = stage.base_increments.rows() > 0 ? Vec3(stage.base_increments.row(node)) : Vec3(Vec3::Zero());
    Vec3 increment = cayley_increment(Vec4(rotations.row(node)), turn);
    if (stage.exponential)
      increment = rotation_vector_of_cayley(increment);
    for (int i = 0; i < 3; ++i) {
      if (hold.turns[static_cast<std::size_t>(i)])
        trial.angular(node, i) = (increment[i] - base[i]) / stage.beta;
    }
  }
}

double Boundary::next_event(double time, double end) const {
  const double near = 1e-9 * std::max(1.0, std::abs(time));
  const auto found = std::upper_bound(m_events.begin(), m_events.end(), time + near);
  return found != m_events.end() && *found < end - near ? *found : end;
}

MotionOfNodes Boundary::accelerations(double time, double dt) const {
  MotionOfNodes motion{Points::Zero(m_layout.node_count(), 3), Points::Zero(m_layout.node_count(), 3)};
  for (const Hold& hold : m_holds) {
    if (hold.motion < 0 || !active(hold, time))
      continue;
    // Velocities in the middles of this step and of one before it: at the ends, keys may have corners.
    const scene::Motion& along = m_motions[hold.motion];
    const scene::Twist now = along.twist(time - 0.5 * dt);
    const scene::Twist before = along.twist(time - 1.5 * dt);
    const scene::Pose pose_now = along.pose(time - 0.5 * dt);
    const scene::Pose pose_before = along.pose(time - 1.5 * dt);
    for (const int node : hold.nodes) {
      const Vec3 rest = m_rest.row(node);
      motion.linear.row(node) = (now.at(pose_now.apply(rest)) - before.at(pose_before.apply(rest))) / dt;
      motion.angular.row(node) = (now.angular - before.angular) / dt;
    }
  }
  return motion;
}

double Boundary::limit_step(double time, double dt) const {
  double fastest = 0.0;
  for (const scene::Motion& motion : m_motions) {
    for (int sample = 0; motion.moves() && sample < SPEED_SAMPLES; ++sample)
      fastest = std::max(fastest, motion.twist(time + dt * sample / SPEED_SAMPLES).angular.norm());
  }
  return fastest * dt > MOST_TURN ? MOST_TURN / fastest : dt;
}

DriveSprings make_drive_springs(const FemPlan& plan, const FemScene& scene) {
  DriveSprings springs;
  for (const DrivenNodes& driven : plan.driven) {
    if (driven.method == DriveMethod::exact)
      continue;
    const int motion = static_cast<int>(springs.motions.size());
    springs.motions.push_back(driven.motion);
    springs.until.push_back(driven.until.value_or(NEVER));
    const bool penalty = driven.method == DriveMethod::penalty;
    const bool turns = driven.drive_microrotations && scene.model.bodies[driven.body].micropolar;
    const std::vector<int> nodes = nodes_of(scene, driven.body, driven.nodes);
    NodeStiffness around;
    if (penalty)
      around = node_stiffness(plan, scene, driven.body);
    double mass = 0.0;
    for (const int node : nodes)
      mass += scene.model.mass[node];
    for (const int node : nodes) {
      const double share = scene.model.mass[node] / mass;
      DriveSpring spring;
      spring.node = node;
      spring.motion = motion;
      spring.rest = scene.start_positions.row(node);
      spring.scales_with_mass = penalty;
      if (driven.drive_positions)
        spring.stiffness = penalty ? PENALTY * around.positions[node] : share * driven.stiffness;
      if (turns)
        spring.turning = penalty ? PENALTY * around.turns[node] : share * driven.turning_stiffness;
      springs.nodes.push_back(spring);
    }
  }
  return springs;
}

} // namespace wry::fem
