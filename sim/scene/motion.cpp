#include "sim/scene/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace wry::scene {

namespace {

constexpr double RADIANS = std::numbers::pi / 180.0;

Mat3 turn(const Vec3& unit_axis, double angle) {
  return Eigen::AngleAxisd(angle, unit_axis).toRotationMatrix();
}

} // namespace

Result<Motion> Motion::through_times(std::vector<double> times) {
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]))
      return make_error(ErrorCode::bad_input, "the time of key {} is not finite", i + 1);
    if (i > 0 && times[i] <= times[i - 1])
      return make_error(ErrorCode::bad_input, "key {} is at {} s, but the one before it is at {} s; times must ascend",
                        i + 1, times[i], times[i - 1]);
  }
  Motion motion;
  motion.m_times = std::move(times);
  return motion;
}

Result<Motion> Motion::along_keys(const MotionKeys& keys) {
  std::vector<double> times;
  for (const MotionKey& key : keys.keys)
    times.push_back(key.time);
  Result<Motion> made = through_times(std::move(times));
  if (!made)
    return made;
  Motion& motion = *made;
  motion.m_pivot = keys.pivot;
  motion.m_ease = keys.ease;
  std::vector<Vec3> axes;
  for (std::size_t i = 0; i < keys.keys.size(); ++i) {
    const MotionKey& key = keys.keys[i];
    if (!key.translation.allFinite() || !std::isfinite(key.degrees))
      return make_error(ErrorCode::bad_input, "key {} is not finite", i + 1);
    const double length = key.axis.norm();
    if (!std::isfinite(length) || length < 1e-12)
      return make_error(ErrorCode::bad_input, "the axis of key {} has no direction", i + 1);
    axes.emplace_back(key.axis / length);
  }
  for (std::size_t i = 0; i + 1 < keys.keys.size() || (i == 0 && keys.keys.size() == 1); ++i) {
    const std::size_t next = std::min(i + 1, keys.keys.size() - 1);
    const MotionKey& from = keys.keys[i];
    const MotionKey& to = keys.keys[next];
    Segment segment;
    segment.start = from.translation;
    segment.change = to.translation - from.translation;
    // A key that does not turn has the axis of the other.
    const bool one_axis = from.degrees == 0 || to.degrees == 0 || (axes[i] - axes[next]).cwiseAbs().maxCoeff() < 1e-12;
    if (one_axis) {
      segment.axis = from.degrees == 0 ? axes[next] : axes[i];
      segment.angle_start = from.degrees * RADIANS;
      segment.angle = to.degrees * RADIANS - segment.angle_start;
    } else {
      segment.base = turn(axes[i], from.degrees * RADIANS);
      const Eigen::AngleAxisd step(Mat3(turn(axes[next], to.degrees * RADIANS) * segment.base.transpose()));
      segment.axis = step.axis();
      segment.angle = step.angle();
    }
    motion.m_segments.push_back(segment);
  }
  return made;
}

Result<Motion> Motion::through_samples(const std::vector<PoseSample>& samples) {
  std::vector<double> times;
  for (const PoseSample& sample : samples)
    times.push_back(sample.time);
  Result<Motion> made = through_times(std::move(times));
  if (!made)
    return made;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Mat3& rotation = samples[i].pose.rotation;
    if (!samples[i].pose.translation.allFinite() || !rotation.allFinite())
      return make_error(ErrorCode::bad_input, "key {} is not finite", i + 1);
    if ((rotation * rotation.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() > 1e-6 || rotation.determinant() < 0)
      return make_error(ErrorCode::bad_input, "key {} scales or mirrors; only rigid motion is possible", i + 1);
  }
  for (std::size_t i = 0; i + 1 < samples.size() || (i == 0 && samples.size() == 1); ++i) {
    const Pose& from = samples[i].pose;
    const Pose& to = samples[std::min(i + 1, samples.size() - 1)].pose;
    Segment segment;
    segment.start = from.translation;
    segment.change = to.translation - from.translation;
    segment.base = from.rotation;
    const Eigen::AngleAxisd step(Mat3(to.rotation * from.rotation.transpose()));
    segment.axis = step.axis();
    segment.angle = step.angle();
    made->m_segments.push_back(segment);
  }
  return made;
}

Motion::Share Motion::share_at(double time) const {
  if (m_times.size() < 2 || time < m_times.front())
    return {};
  if (time >= m_times.back())
    return {m_segments.size() - 1, 1.0, 0.0};
  const auto after = std::upper_bound(m_times.begin(), m_times.end(), time);
  const auto segment = static_cast<std::size_t>(after - m_times.begin()) - 1;
  const double length = m_times[segment + 1] - m_times[segment];
  const double s = (time - m_times[segment]) / length;
  if (m_ease == Ease::smooth)
    return {segment, s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / length};
  return {segment, s, 1.0 / length};
}

Mat3 Motion::rotation_of(const Segment& segment, double share) {
  return turn(segment.axis, segment.angle_start + share * segment.angle) * segment.base;
}

Pose Motion::pose(double time) const {
  if (m_segments.empty())
    return {};
  const Share share = share_at(time);
  const Segment& segment = m_segments[share.segment];
  Pose pose;
  pose.rotation = rotation_of(segment, share.value);
  pose.translation = segment.start + share.value * segment.change + m_pivot - pose.rotation * m_pivot;
  return pose;
}

Twist Motion::twist(double time) const {
  Twist twist;
  if (m_segments.empty())
    return twist;
  const Share share = share_at(time);
  const Segment& segment = m_segments[share.segment];
  twist.angular = share.rate * segment.angle * segment.axis;
  const Vec3 pivot_now = m_pivot + segment.start + share.value * segment.change;
  twist.linear = share.rate * segment.change - twist.angular.cross(pivot_now);
  return twist;
}

} // namespace wry::scene
