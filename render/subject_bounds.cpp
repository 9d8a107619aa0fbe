#include "render/subject_bounds.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace wry::render {
namespace {

constexpr int DIRECTION_COUNT = 256;

/// Directions spread evenly over the sphere by the golden angle, a row each.
Points spread_directions() {
  Points directions(DIRECTION_COUNT, 3);
  const double golden_angle = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < DIRECTION_COUNT; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / DIRECTION_COUNT;
    const double ring = std::sqrt(1.0 - z * z);
    directions.row(i) << ring * std::cos(golden_angle * i), ring * std::sin(golden_angle * i), z;
  }
  return directions;
}

const Points& directions() {
  static const Points spread = spread_directions();
  return spread;
}

} // namespace

SubjectBounds::SubjectBounds()
    : m_reach(Eigen::VectorXd::Constant(DIRECTION_COUNT, -std::numeric_limits<double>::infinity()))
    , m_outline(Points::Zero(DIRECTION_COUNT, 3)) {}

void SubjectBounds::include(const Eigen::Ref<const Points>& points) {
  Eigen::VectorXd reach(DIRECTION_COUNT);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Vec3 point = points.row(i).transpose();
    if (!point.allFinite())
      continue;
    m_box.extend(point);
    reach.noalias() = directions() * point;
    for (int d = 0; d < DIRECTION_COUNT; ++d) {
      if (reach[d] > m_reach[d]) {
        m_reach[d] = reach[d];
        m_outline.row(d) = point.transpose();
      }
    }
  }
}

Status SubjectBounds::include(const SceneStatic& scene, const Frame& frame) {
  if (scene.bodies.size() != frame.bodies.size())
    return make_error(ErrorCode::bad_input, "frame {} has {} bodies, the scene {}: they are not of the same run",
                      frame.number, frame.bodies.size(), scene.bodies.size());
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (scene.bodies[b].kind == BodyKind::particles) {
      if (const Status good = include_cloud(scene.bodies[b], frame.bodies[b], frame.number); !good.ok())
        return good.error();
      continue;
    }
    if (scene.bodies[b].triangles.rows() == 0) // nothing of it is drawn, as of particles that carry grains
      continue;
    const Result<Points> positions = world_positions(scene.bodies[b], frame.bodies[b], frame.number);
    if (!positions.ok())
      return positions.error();
    include(*positions);
  }
  return {};
}

Status SubjectBounds::include_cloud(const SceneBody& body, const FrameBody& on_frame, int frame_number) {
  const Channel* channel = find_channel(on_frame, "position");
  if (channel == nullptr || channel->components != 3 || channel->values.size() % 3 != 0)
    return make_error(ErrorCode::bad_input, "frame {}, body {}: particles need a channel position of 3 components",
                      frame_number, body.name);
  if (channel->values.empty())
    return {};
  SubjectBounds centres;
  centres.include(
      Eigen::Map<const Points>(channel->values.data(), static_cast<Eigen::Index>(channel->values.size() / 3), 3));
  if (centres.empty())
    return {};
  // No grain reaches farther from its centre than half its diagonal.
  double reach = 0.5 * body.grain.size.norm();
  if (body.grain.shape == GrainShape::mesh && body.rest_positions.rows() > 0)
    reach = (body.rest_positions * body.grain.size.asDiagonal()).rowwise().norm().maxCoeff();
  include(Points(centres.m_outline + reach * directions()));
  m_box.extend(Eigen::AlignedBox3d(centres.m_box.min().array() - reach, centres.m_box.max().array() + reach));
  return {};
}

void SubjectBounds::include(const SubjectBounds& other) {
  if (other.empty())
    return;
  include(other.m_outline);
  m_box.extend(other.m_box);
}

Result<Points> world_positions(const SceneBody& body, const FrameBody& on_frame, int frame_number) {
  Points positions;
  if (const Channel* channel = find_channel(on_frame, "position"); channel != nullptr) {
    const Eigen::Index count = body.rest_positions.rows();
    if (channel->components != 3 || channel->values.size() != static_cast<std::size_t>(count) * 3)
      return make_error(ErrorCode::bad_input, "frame {}, body {}: {} position values for {} vertices; expected {}",
                        frame_number, body.name, channel->values.size(), count, count * 3);
    positions = Eigen::Map<const Points>(channel->values.data(), count, 3);
  } else {
    const Mat3 linear = on_frame.transform.topLeftCorner<3, 3>();
    const Vec3 shift = on_frame.transform.topRightCorner<3, 1>();
    positions = (body.rest_positions * linear.transpose()).rowwise() + shift.transpose();
  }
  for (Eigen::Index i = 0; i < positions.rows(); ++i) {
    if (!positions.row(i).allFinite())
      return make_error(ErrorCode::bad_input,
                        "frame {}, body {}: the position of vertex {} of {} is not a finite number; the frame is not "
                        "drawn. Check the simulation at this frame",
                        frame_number, body.name, i, positions.rows());
  }
  return positions;
}

} // namespace wry::render
