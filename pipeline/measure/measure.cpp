#include "pipeline/measure/measure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace wry::pipeline {

namespace {

using PointMap = Eigen::Map<const Points>;

PointMap rows_of(const FrameBody& body, const std::string& channel_name) {
  const Channel* channel = find_channel(body, channel_name);
  if (channel == nullptr || channel->components != 3)
    return PointMap(nullptr, 0, 3);
  return PointMap(channel->values.data(), static_cast<Eigen::Index>(channel->values.size() / 3), 3);
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
  for (Eigen::Index tet = 0; tet < body.tets.rows(); ++tet) {
    double squares = 0.0;
    for (int corner = 0; corner < 4; ++corner)
      squares += velocities.row(body.tets(tet, corner)).squaredNorm();
    sum += 0.5 * plan.density * tet_volume(body.tets, tet, body.rest_positions) * squares / 4.0;
  }
  return sum;
}

double strain_energy(const MeasurePlan&, const SceneBody& body, const FrameBody& frame) {
  const Channel* density = find_channel(frame, "strain_energy_density");
  if (density == nullptr)
    return std::numeric_limits<double>::quiet_NaN();
  double sum = 0.0;
  for (Eigen::Index tet = 0; tet < body.tets.rows(); ++tet)
    sum += density->values[static_cast<std::size_t>(tet)] * tet_volume(body.tets, tet, body.rest_positions);
  return sum;
}

using Kind = shots::MeasureKind;
constexpr std::array MEASURE_FUNCTIONS = {
    MeasureFunction{Kind::height, "height", "m", "extent along the shot's up axis", extent},
    MeasureFunction{Kind::extent, "extent", "m", "extent along an axis", extent},
    MeasureFunction{Kind::lowest, "lowest", "m", "lowest coordinate along up", lowest},
    MeasureFunction{Kind::centre, "centre", "m", "mean of the nodes along an axis", centre},
    MeasureFunction{Kind::volume, "volume", "m^3", "volume of the tets as they are now", volume},
    MeasureFunction{Kind::speed, "speed", "m/s", "speed of the fastest node", speed},
    MeasureFunction{Kind::kinetic_energy, "kinetic_energy", "J", "of the lumped masses", kinetic_energy},
    MeasureFunction{Kind::strain_energy, "strain_energy", "J", "elastic energy stored in the body", strain_energy},
};

} // namespace

std::span<const MeasureFunction> measure_functions() {
  return MEASURE_FUNCTIONS;
}

double evaluate_measure(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame) {
  for (const MeasureFunction& function : MEASURE_FUNCTIONS) {
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
