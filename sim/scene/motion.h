#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "sim/base/result.h"
#include "sim/base/types.h"

namespace wry::scene {

/// A rigid placement: x -> rotation x + translation.
struct Pose {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero(); ///< [m]

  Vec3 apply(const Vec3& point) const { return rotation * point + translation; }
  Vec3 apply_inverse(const Vec3& point) const { return rotation.transpose() * (point - translation); }
};

/// Rigid velocity: of the point x it is linear + angular x x.
struct Twist {
  Vec3 linear = Vec3::Zero();  ///< of the world's origin, taken along [m/s]
  Vec3 angular = Vec3::Zero(); ///< [rad/s], in the world

  Vec3 at(const Vec3& point) const { return linear + angular.cross(point); }
};

/// Where something that moves as a whole is at one time, relative to where it rests.
struct MotionKey {
  double time = 0;                 ///< [s]
  Vec3 translation = Vec3::Zero(); ///< [m]
  Vec3 axis = Vec3::UnitY();       ///< of the turn about the pivot; not zero
  double degrees = 0;
};

/// How a motion goes from key to key.
enum class Ease {
  linear, ///< at constant speed
  smooth, ///< starting and ending at rest
};

/// Keys in time. Between keys of the same axis the angle itself is interpolated, so that a motion may turn many times;
/// between keys of different axes it goes the shortest way.
struct MotionKeys {
  std::vector<MotionKey> keys; ///< times ascend
  Vec3 pivot = Vec3::Zero();   ///< the point that turns leave in place, before the translation [m]
  Ease ease = Ease::linear;
};

/// A pose at a time, from a file's animation.
struct PoseSample {
  double time = 0; ///< [s]
  Pose pose;
};

/// How something moves as a whole, from where it rests into the world; immutable. Before its first and after its last
/// time it stands still.
class Motion {
public:
  /// Stands still where it rests.
  Motion() = default;

  /// Errors: bad_input for times that do not ascend, a zero axis, or what is not finite, naming the key by its index
  /// from 1.
  static Result<Motion> along_keys(const MotionKeys& keys);
  /// Goes from sample to sample at constant speed, turning the shortest way. Errors as above, and for rotations that
  /// are none.
  static Result<Motion> through_samples(const std::vector<PoseSample>& samples);

  bool moves() const { return m_times.size() > 1; }
  double first_time() const { return m_times.empty() ? 0.0 : m_times.front(); } ///< [s]
  const std::vector<double>& key_times() const { return m_times; }              ///< ascending [s]
  double last_time() const { return m_times.empty() ? 0.0 : m_times.back(); }   ///< [s]

  Pose pose(double time) const;
  /// Velocity of the matter in place at `time`; where it jumps, that of the coming segment.
  Twist twist(double time) const;

private:
  /// One stretch between two times: the rotation is turn(axis, angle_start + share * angle) * base.
  struct Segment {
    Vec3 start = Vec3::Zero(), change = Vec3::Zero(); ///< of the pivot's translation [m]
    Vec3 axis = Vec3::UnitY();
    double angle_start = 0, angle = 0; ///< [rad]
    Mat3 base = Mat3::Identity();
  };
  struct Share {
    std::size_t segment = 0;
    double value = 0; ///< 0..1, eased
    double rate = 0;  ///< of value [1/s]
  };
  static Result<Motion> through_times(std::vector<double> times);
  Share share_at(double time) const;
  static Mat3 rotation_of(const Segment& segment, double share);

  std::vector<double> m_times;
  std::vector<Segment> m_segments; ///< between the times; a single one when it stands still away from its rest
  Vec3 m_pivot = Vec3::Zero();
  Ease m_ease = Ease::linear;
};

} // namespace wry::scene
