#include "pipeline/measure/measure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "pipeline/measure/crossing_measures.h"
#include "pipeline/measure/fibre_measures.h"
#include "pipeline/measure/grain_measures.h"
#include "pipeline/measure/pile_measures.h"
#include "pipeline/measure/rotation_measures.h"

namespace wry::pipeline {

namespace {

PointMap rows_of(const FrameBody& body, const std::string& channel_name) {
  return point_channel(body, channel_name);
}

template <class Visit> void for_nodes(const MeasurePlan& plan, const PointMap& points, const Visit& visit) {
  if (!plan.nodes.empty()) {
    for (const std::int32_t node : plan.nodes)
      visit(node, Vec3(points.row(node)));
    return;
  }
  for (Eigen::Index node = 0; node < points.rows(); ++node)
    visit(node, Vec3(points.row(node)));
}

struct Interval {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
};

Interval interval_along(const MeasurePlan& plan, const FrameBody& frame) {
  Interval interval;
  for_nodes(plan, rows_of(frame, "position"), [&](Eigen::Index, const Vec3& point) {
    interval.low = std::min(interval.low, point.dot(plan.direction));
    interval.high = std::max(interval.high, point.dot(plan.direction));
  });
  return interval;
}

double extent(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  const Interval interval = interval_along(plan, frame);
  return interval.high - interval.low;
}

double lowest(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  return interval_along(plan, frame).low;
}

double centre(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  double sum = 0.0;
  int count = 0;
  for_nodes(plan, rows_of(frame, "position"), [&](Eigen::Index, const Vec3& point) {
    sum += point.dot(plan.direction);
    ++count;
  });
  return sum / count;
}

double tet_volume(const Tets& tets, Eigen::Index tet, const Eigen::Ref<const Points>& points) {
  const Vec3 origin = points.row(tets(tet, 0));
  const Vec3 a = points.row(tets(tet, 1)).transpose() - origin;
  const Vec3 b = points.row(tets(tet, 2)).transpose() - origin;
  const Vec3 c = points.row(tets(tet, 3)).transpose() - origin;
  return a.cross(b).dot(c) / 6.0;
}

double volume(const MeasurePlan&, const SceneBody& body, const FrameBody& frame) {
  const PointMap points = rows_of(frame, "position");
  double sum = 0.0;
  for (Eigen::Index tet = 0; tet < body.tets.rows(); ++tet)
    sum += tet_volume(body.tets, tet, points);
  return sum;
}

double speed(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  double fastest = 0.0;
  for_nodes(plan, rows_of(frame, "velocity"),
            [&](Eigen::Index, const Vec3& velocity) { fastest = std::max(fastest, velocity.norm()); });
  return fastest;
}

double kinetic_energy(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame) {
  const PointMap velocities = rows_of(frame, "velocity");
  double sum = 0.0;
  if (plan.particle_mass > 0.0)
    return 0.5 * plan.particle_mass * velocities.squaredNorm();
  for (Eigen::Index tet = 0; tet < body.tets.rows(); ++tet) {
    double squares = 0.0;
    for (int corner = 0; corner < 4; ++corner)
      squares += velocities.row(body.tets(tet, corner)).squaredNorm();
    sum += 0.5 * plan.density * tet_volume(body.tets, tet, body.rest_positions) * squares / 4.0;
  }
  return sum;
}

double integral_over_tets(const char* name, const SceneBody& body, const FrameBody& frame) {
  const Channel* density = find_channel(frame, name);
  if (density == nullptr)
    return std::numeric_limits<double>::quiet_NaN();
  double sum = 0.0;
  for (Eigen::Index tet = 0; tet < body.tets.rows(); ++tet)
    sum += density->values[static_cast<std::size_t>(tet)] * tet_volume(body.tets, tet, body.rest_positions);
  return sum;
}

double strain_energy(const MeasurePlan&, const SceneBody& body, const FrameBody& frame) {
  return integral_over_tets("strain_energy_density", body, frame);
}

double low(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  return interval_along(plan, frame).low;
}

double high(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  return interval_along(plan, frame).high;
}

/// The mean over the nodes that rest within a thousandth of the far end of the body's longest side.
double tip_position(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame) {
  const Vec3 least = body.rest_positions.colwise().minCoeff();
  const Vec3 most = body.rest_positions.colwise().maxCoeff();
  int along = 0;
  const double length = (most - least).maxCoeff(&along);
  double sum = 0.0;
  int count = 0;
  for_nodes(plan, rows_of(frame, "position"), [&](Eigen::Index node, const Vec3& point) {
    if (body.rest_positions(node, along) < most[along] - 1e-3 * length)
      return;
    sum += point.dot(plan.direction);
    ++count;
  });
  return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

double curvature_energy(const MeasurePlan&, const SceneBody& body, const FrameBody& frame) {
  return integral_over_tets("curvature_energy_density", body, frame);
}

/// The lumped masses of the nodes.
std::vector<double> node_masses(const MeasurePlan& plan, const SceneBody& body) {
  std::vector<double> masses(static_cast<std::size_t>(body.rest_positions.rows()), 0.0);
  for (Eigen::Index tet = 0; tet < body.tets.rows(); ++tet) {
    const double share = 0.25 * plan.density * tet_volume(body.tets, tet, body.rest_positions);
    for (int corner = 0; corner < 4; ++corner)
      masses[static_cast<std::size_t>(body.tets(tet, corner))] += share;
  }
  return masses;
}

double momentum(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame) {
  const std::vector<double> masses = node_masses(plan, body);
  double sum = 0.0;
  for_nodes(plan, rows_of(frame, "velocity"), [&](Eigen::Index node, const Vec3& velocity) {
    sum += masses[static_cast<std::size_t>(node)] * velocity.dot(plan.direction);
  });
  return sum;
}

Vec3 middle_of(const MeasurePlan& plan, const FrameBody& frame) {
  if (plan.about)
    return *plan.about;
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for_nodes(plan, rows_of(frame, "position"), [&](Eigen::Index, const Vec3& point) {
    sum += point;
    ++count;
  });
  return sum / count;
}

double angular_momentum(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame) {
  const std::vector<double> masses = node_masses(plan, body);
  const PointMap positions = rows_of(frame, "position");
  const Vec3 about = middle_of(plan, frame);
  double sum = 0.0;
  for_nodes(plan, rows_of(frame, "velocity"), [&](Eigen::Index node, const Vec3& velocity) {
    const Vec3 arm = positions.row(node).transpose() - about;
    sum += masses[static_cast<std::size_t>(node)] * arm.cross(velocity).dot(plan.direction);
  });
  return sum;
}

double reaction_force(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  const PointMap forces = rows_of(frame, "reaction_force");
  if (forces.rows() == 0)
    return std::numeric_limits<double>::quiet_NaN();
  double sum = 0.0;
  for_nodes(plan, forces, [&](Eigen::Index, const Vec3& force) { sum += force.dot(plan.direction); });
  return sum;
}

double reaction_torque(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  const PointMap forces = rows_of(frame, "reaction_force");
  const PointMap torques = rows_of(frame, "reaction_torque");
  const PointMap positions = rows_of(frame, "position");
  if (forces.rows() == 0 || torques.rows() == 0)
    return std::numeric_limits<double>::quiet_NaN();
  const Vec3 about = middle_of(plan, frame);
  double sum = 0.0;
  for_nodes(plan, forces, [&](Eigen::Index node, const Vec3& force) {
    const Vec3 arm = positions.row(node).transpose() - about;
    sum += (arm.cross(force) + torques.row(node).transpose()).dot(plan.direction);
  });
  return sum;
}

using Kind = shots::MeasureKind;
constexpr std::array MEASURE_FUNCTIONS = {
    MeasureFunction{Kind::height, "height", "m", "extent along the shot's up axis", MeasuredOn::both, extent},
    MeasureFunction{Kind::extent, "extent", "m", "extent along an axis", MeasuredOn::both, extent},
    MeasureFunction{Kind::lowest, "lowest", "m", "lowest coordinate along up", MeasuredOn::both, lowest},
    MeasureFunction{Kind::centre, "centre", "m", "mean of the nodes along an axis", MeasuredOn::both, centre},
    MeasureFunction{Kind::volume, "volume", "m^3", "volume of the tets as they are now", MeasuredOn::solids, volume},
    MeasureFunction{Kind::speed, "speed", "m/s", "speed of the fastest node", MeasuredOn::both, speed},
    MeasureFunction{Kind::kinetic_energy, "kinetic_energy", "J", "of the lumped masses", MeasuredOn::both,
                    kinetic_energy},
    MeasureFunction{Kind::strain_energy, "strain_energy", "J", "elastic energy stored in the body", MeasuredOn::solids,
                    strain_energy},
    MeasureFunction{Kind::run_out, "run_out", "", "how far 98 % of the particles spread, over the start's half width",
                    MeasuredOn::particles, run_out},
    MeasureFunction{Kind::front_position, "front_position", "m", "behind it along the axis are 98 % of the particles",
                    MeasuredOn::particles, front_position},
    MeasureFunction{Kind::pile_height, "pile_height", "m", "of the highest particle above the start's foot",
                    MeasuredOn::particles, pile_height},
    MeasureFunction{Kind::repose_angle, "repose_angle", "degrees", "slope of the pile's surface about its middle",
                    MeasuredOn::particles, repose_angle},
    MeasureFunction{Kind::fraction_outside, "fraction_outside", "", "part of the particles that are not in the region",
                    MeasuredOn::particles, fraction_outside},
    MeasureFunction{Kind::curvature_energy, "curvature_energy", "J", "the part of curvature in it", MeasuredOn::solids,
                    curvature_energy},
    MeasureFunction{Kind::bound_low, "bound_low", "m", "least coordinate along an axis", MeasuredOn::both, low},
    MeasureFunction{Kind::bound_high, "bound_high", "m", "greatest coordinate along an axis", MeasuredOn::both, high},
    MeasureFunction{Kind::tip_position, "tip_position", "m", "mean of the nodes at the far end", MeasuredOn::solids,
                    tip_position},
    MeasureFunction{Kind::momentum, "momentum", "kg m/s", "of the lumped masses, along an axis", MeasuredOn::solids,
                    momentum},
    MeasureFunction{Kind::angular_momentum, "angular_momentum", "kg m^2/s", "of the lumped masses, about an axis",
                    MeasuredOn::solids, angular_momentum},
    MeasureFunction{Kind::reaction_force, "reaction_force", "N", "of holds and drives, along an axis",
                    MeasuredOn::solids, reaction_force},
    MeasureFunction{Kind::reaction_torque, "reaction_torque", "N m", "of holds and drives, about an axis",
                    MeasuredOn::solids, reaction_torque},
    MeasureFunction{Kind::element_twist_max, "element_twist_max", "degrees",
                    "largest angle between nodes of an element", MeasuredOn::solids, element_twist_max},
    MeasureFunction{Kind::rotation_distance, "rotation_distance", "degrees",
                    "mean angle of microrotations to the matter's rotation", MeasuredOn::solids, rotation_distance},
    MeasureFunction{Kind::curvature_error, "curvature_error", "", "largest relative error of the wryness",
                    MeasuredOn::solids, curvature_error},
    MeasureFunction{Kind::rotation_interpolation_error, "rotation_interpolation_error", "degrees",
                    "largest angle to the spherical average", MeasuredOn::solids, rotation_interpolation_error},
    MeasureFunction{Kind::curve_radius, "curve_radius", "m", "of the helix that a slender body forms",
                    MeasuredOn::solids, curve_radius},
    MeasureFunction{Kind::curve_pitch, "curve_pitch", "m", "of that helix", MeasuredOn::solids, curve_pitch},
    MeasureFunction{Kind::mean_alignment, "mean_alignment", "", "mean square of the cosine of fibres and the axis",
                    MeasuredOn::particles, mean_alignment},
    MeasureFunction{Kind::second_moment, "second_moment", "", "greatest eigenvalue of the fibres' mean second moment",
                    MeasuredOn::particles, second_moment},
    MeasureFunction{Kind::largest_fragment, "largest_fragment", "", "part of the particles in the largest piece",
                    MeasuredOn::particles, largest_fragment},
    MeasureFunction{Kind::grains_inside, "grains_inside", "", "grains with their centre inside a collider",
                    MeasuredOn::particles, nullptr, grains_inside},
    MeasureFunction{Kind::grain_hover, "grain_hover", "m", "gap below grains at rest, of 99 % of them",
                    MeasuredOn::particles, nullptr, grain_hover},
    MeasureFunction{Kind::crossings, "crossings", "", "edges that cut triangles of the body itself or other solids",
                    MeasuredOn::solids, nullptr, crossings},
};

} // namespace

MeasuredOn measured_on(shots::MeasureKind kind) {
  for (const MeasureFunction& function : MEASURE_FUNCTIONS) {
    if (function.kind == kind)
      return function.on;
  }
  return MeasuredOn::both;
}

std::span<const MeasureFunction> measure_functions() {
  return MEASURE_FUNCTIONS;
}

double evaluate_measure(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame) {
  for (const MeasureFunction& function : MEASURE_FUNCTIONS) {
    if (function.kind == plan.kind && function.evaluate == nullptr)
      return function.evaluate_in_scene(plan, scene, frame);
    if (function.kind == plan.kind)
      return function.evaluate(plan, scene.bodies[plan.body], frame.bodies[plan.body]);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double measured_value(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame) {
  const double value = evaluate_measure(plan, scene, frame);
  return plan.reference ? value / *plan.reference : value;
}

} // namespace wry::pipeline
