#include "pipeline/measure/pile_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/base/parallel.h"

namespace wry::pipeline {

namespace {

constexpr double MOST = 0.98;
constexpr double NOTHING = std::numeric_limits<double>::quiet_NaN();

/// The value below which a share of the values is.
double quantile(std::vector<double> values, double share) {
  if (values.empty())
    return NOTHING;
  std::sort(values.begin(), values.end());
  const double place = share * static_cast<double>(values.size() - 1);
  const std::size_t below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

Vec3 middle(const MeasurePlan& plan) {
  return 0.5 * (plan.start_low + plan.start_high);
}

bool is_around_up(const MeasurePlan& plan) {
  return std::abs(plan.direction.dot(plan.up)) > 0.999;
}

template <class Visit> void for_particles(const MeasurePlan& plan, const PointMap& points, const Visit& visit) {
  if (plan.nodes.empty()) {
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      visit(Vec3(points.row(i)));
    return;
  }
  for (const std::int32_t i : plan.nodes)
    visit(Vec3(points.row(i)));
}

} // namespace

PointMap point_channel(const FrameBody& body, const std::string& name) {
  const Channel* channel = find_channel(body, name);
  if (channel == nullptr || channel->components != 3)
    return PointMap(nullptr, 0, 3);
  return PointMap(channel->values.data(), static_cast<Eigen::Index>(channel->values.size() / 3), 3);
}

double run_out(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  const Vec3 half = 0.5 * (plan.start_high - plan.start_low);
  const Vec3 level = half - half.dot(plan.up) * plan.up;
  std::vector<double> distances;
  for_particles(plan, point_channel(frame, "position"), [&](const Vec3& point) {
    const Vec3 away = point - middle(plan);
    distances.push_back(is_around_up(plan) ? (away - away.dot(plan.up) * plan.up).norm()
                                           : std::abs(away.dot(plan.direction)));
  });
  // Around up: the start's mean half width, its radius when it is a cylinder.
  const double start = is_around_up(plan) ? level.cwiseAbs().sum() / 2.0 : std::abs(half.dot(plan.direction));
  return quantile(std::move(distances), MOST) / start - 1.0;
}

double front_position(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  std::vector<double> places;
  for_particles(plan, point_channel(frame, "position"),
                [&](const Vec3& point) { places.push_back(point.dot(plan.direction)); });
  return quantile(std::move(places), MOST);
}

namespace {

/// The points that are in the measure's region now.
std::vector<std::int32_t> points_within(const MeasurePlan& plan, const PointMap& points) {
  scene::RestPoints now;
  now.positions = points;
  Result<std::vector<std::int32_t>> inside = scene::select_points(*plan.region, now, Threads(1));
  // That no point is in it is an error of regions that pick nodes.
  return inside ? std::move(*inside) : std::vector<std::int32_t>{};
}

} // namespace

double pile_height(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  if (plan.region) {
    const PointMap points = point_channel(frame, "position");
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const std::int32_t i : points_within(plan, points)) {
      low = std::min(low, points.row(i).dot(plan.up));
      high = std::max(high, points.row(i).dot(plan.up));
    }
    return high > low ? high - low : 0.0;
  }
  double highest = -std::numeric_limits<double>::infinity();
  for_particles(plan, point_channel(frame, "position"),
                [&](const Vec3& point) { highest = std::max(highest, point.dot(plan.up)); });
  return std::isfinite(highest) ? highest - plan.start_low.dot(plan.up) : NOTHING;
}

double repose_angle(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  // The surface: the highest particle of every ring around the middle, a particle's spacing wide.
  const double spacing = 2.0 * std::cbrt(plan.particle_mass / plan.density);
  const double foot = plan.start_low.dot(plan.up);
  std::vector<double> surface;
  for_particles(plan, point_channel(frame, "position"), [&](const Vec3& point) {
    const Vec3 away = point - middle(plan);
    const double radius = (away - away.dot(plan.up) * plan.up).norm();
    constexpr double MOST_RINGS = 1e5;
    const std::size_t ring = static_cast<std::size_t>(std::min(MOST_RINGS, radius / spacing));
    if (ring >= surface.size())
      surface.resize(ring + 1, 0.0);
    surface[ring] = std::max(surface[ring], point.dot(plan.up) - foot);
  });
  if (surface.empty())
    return NOTHING;
  const double height = *std::max_element(surface.begin(), surface.end());
  double count = 0.0, sum_r = 0.0, sum_h = 0.0, sum_rr = 0.0, sum_rh = 0.0;
  for (std::size_t ring = 0; ring < surface.size(); ++ring) {
    const double h = surface[ring];
    if (h < 0.2 * height || h > 0.8 * height)
      continue;
    const double r = (static_cast<double>(ring) + 0.5) * spacing;
    count += 1.0;
    sum_r += r;
    sum_h += h;
    sum_rr += r * r;
    sum_rh += r * h;
  }
  const double spread = count * sum_rr - sum_r * sum_r;
  if (!(spread > 0.0))
    return NOTHING;
  const double slope = (count * sum_rh - sum_r * sum_h) / spread;
  return std::atan(-slope) * 180.0 / std::numbers::pi;
}

double fraction_outside(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  const PointMap points = point_channel(frame, "position");
  if (!plan.region || points.rows() == 0)
    return NOTHING;
  return 1.0 - static_cast<double>(points_within(plan, points).size()) / static_cast<double>(points.rows());
}

} // namespace wry::pipeline
