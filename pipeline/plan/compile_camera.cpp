#include "pipeline/plan/compile_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/assets/motion_import.h"
#include "pipeline/plan/compile_fem.h"

namespace wry::pipeline {

namespace {

/// The eye of a camera at a given distance from its target, on the orbit's angles.
Vec3 eye_on_orbit(const shots::Camera& camera, const Vec3& target, const Vec3& up) {
  constexpr double DEGREE = std::numbers::pi / 180.0;
  const double azimuth = *camera.azimuth_deg * DEGREE;
  const double elevation = *camera.elevation_deg * DEGREE;
  return target + **camera.distance *
                      (render::world_frame(up) * Vec3(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                                                      std::cos(elevation) * std::cos(azimuth)));
}

} // namespace

Result<CameraMotion> CameraMotion::create(const shots::Shot& shot, const SceneStatic& scene,
                                          const render::SubjectBounds& bounds) {
  const shots::Camera& camera = shot.render.camera;
  CameraMotion motion;
  motion.m_up = axis_vector(*shot.shot.up);
  motion.m_size = {static_cast<int>((*shot.render.size)[0]), static_cast<int>((*shot.render.size)[1])};
  motion.m_bounds = bounds;
  motion.m_plan.lens_mm = *camera.lens;
  motion.m_plan.azimuth_degrees = *camera.azimuth_deg;
  motion.m_plan.elevation_degrees = *camera.elevation_deg;
  motion.m_plan.margin = *camera.margin;
  const Vec3 target = camera.target ? **camera.target : bounds.centre();
  if (camera.position)
    motion.m_plan.placed = render::PlacedCamera{**camera.position, target, {}};
  else if (camera.distance)
    motion.m_plan.placed = render::PlacedCamera{eye_on_orbit(camera, target, motion.m_up), target, {}};
  if (shot.render.depth_of_field) {
    motion.m_plan.f_stop = *shot.render.depth_of_field->f_stop;
    if (shot.render.depth_of_field->focus)
      motion.m_plan.focus_distance = **shot.render.depth_of_field->focus;
  }
  for (const shots::CameraKey& key : camera.keys) {
    Key made;
    made.frame = static_cast<double>(*key.frame);
    made.place << *key.position, (key.target ? **key.target : target), (key.lens ? **key.lens : *camera.lens);
    if (!motion.m_keys.empty() && !(made.frame > motion.m_keys.back().frame))
      return make_error(ErrorCode::bad_input, "{}: frame {} comes after frame {}; put the keys in order, one a frame",
                        key.frame.source.text(), *key.frame, motion.m_keys.back().frame);
    motion.m_keys.push_back(made);
  }
  motion.m_turns = *camera.orbit_turns;
  motion.m_first = shot.shot.frames->first();
  motion.m_last = std::max<double>(shot.shot.frames->last(), motion.m_first + 1);
  if (camera.look_at) {
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      if (scene.bodies[b].name == **camera.look_at)
        motion.m_body = static_cast<int>(b);
    }
    if (motion.m_body < 0)
      return make_error(ErrorCode::bad_input, "{}: the frames have no body '{}'", camera.look_at->source.text(),
                        **camera.look_at);
    motion.m_looked_at = scene.bodies[static_cast<std::size_t>(motion.m_body)];
  }
  if (!motion.m_keys.empty())
    motion.m_plan = motion.along_keys(motion.m_first);
  if (camera.file) {
    if (Status status = motion.take_file(camera, *shot.shot.up); !status)
      return at_source(camera.file->source, status.error());
  }
  return motion;
}

Status CameraMotion::take_file(const shots::Camera& camera, shots::Axis up) {
  MeshImportOptions options;
  options.scene_up = static_cast<geometry::Axis>(up);
  options.node = camera.node ? **camera.node : std::string();
  const Result<ImportedMotion> imported = import_motion(**camera.file, options);
  if (!imported)
    return imported.error();
  if (!imported->camera_fov)
    return make_error(ErrorCode::bad_input, "{}: node '{}' is no camera", **camera.file, options.node);
  constexpr double HALF_FILM_MM = 18.0;
  if (!camera.lens.given())
    m_plan.lens_mm = std::clamp(HALF_FILM_MM / std::tan(0.5 * *imported->camera_fov), 10.0, 1000.0);
  if (!imported->samples.empty()) {
    Result<scene::Motion> motion = scene::Motion::through_samples(imported->samples);
    if (!motion)
      return motion.error();
    m_file_motion = std::move(*motion);
  }
  m_plan = along_file(m_file_motion.moves() ? m_file_motion.pose(0.0) : imported->rest);
  return {};
}

/// A camera of a file looks along its -z. What it looks at is put as far away as the subject, so that an orbit turns
/// about something sensible.
render::CameraPlan CameraMotion::along_file(const scene::Pose& pose) const {
  render::CameraPlan plan = m_plan;
  const Vec3 forward = -pose.rotation.col(2);
  const double reach = std::max(forward.dot(m_bounds.centre() - pose.translation), 0.1 * m_bounds.radius());
  plan.placed = render::PlacedCamera{pose.translation, pose.translation + reach * forward, pose.rotation.col(1)};
  return plan;
}

/// Cubic pieces whose slopes at a key are those between its neighbours (Catmull and Rom 1974); still beyond the ends.
render::CameraPlan CameraMotion::along_keys(double frame) const {
  render::CameraPlan plan = m_plan;
  const auto next = std::upper_bound(m_keys.begin(), m_keys.end(), frame,
                                     [](double value, const Key& key) { return value < key.frame; });
  Eigen::Matrix<double, 7, 1> place;
  if (next == m_keys.begin()) {
    place = m_keys.front().place;
  } else if (next == m_keys.end()) {
    place = m_keys.back().place;
  } else {
    const std::size_t right = static_cast<std::size_t>(next - m_keys.begin());
    const std::size_t left = right - 1;
    const auto slope = [&](std::size_t i) {
      const std::size_t before = i > 0 ? i - 1 : i;
      const std::size_t after = std::min(i + 1, m_keys.size() - 1);
      return Eigen::Matrix<double, 7, 1>((m_keys[after].place - m_keys[before].place) /
                                         (m_keys[after].frame - m_keys[before].frame));
    };
    const double length = m_keys[right].frame - m_keys[left].frame;
    const double s = (frame - m_keys[left].frame) / length;
    const double s2 = s * s;
    const double s3 = s2 * s;
    place = (2 * s3 - 3 * s2 + 1) * m_keys[left].place + (s3 - 2 * s2 + s) * length * slope(left) +
            (3 * s2 - 2 * s3) * m_keys[right].place + (s3 - s2) * length * slope(right);
  }
  plan.placed = render::PlacedCamera{place.head<3>(), place.segment<3>(3), {}};
  plan.lens_mm = std::clamp(place[6], 10.0, 1000.0);
  return plan;
}

Result<render::CameraPlan> CameraMotion::at(const Frame& frame) const {
  render::CameraPlan plan = !m_keys.empty()         ? along_keys(frame.number)
                            : m_file_motion.moves() ? along_file(m_file_motion.pose(frame.time))
                                                    : m_plan;
  const double turns = m_turns * (frame.number - m_first) / (m_last - m_first);
  if (plan.placed) {
    const Vec3 arm = plan.placed->eye - plan.placed->target;
    const Eigen::AngleAxisd turn(2.0 * std::numbers::pi * turns, m_up);
    plan.placed->eye = plan.placed->target + turn * arm;
    if (plan.placed->up)
      plan.placed->up = turn * *plan.placed->up;
  } else {
    plan.azimuth_degrees += 360.0 * turns;
  }
  if (m_body < 0)
    return plan;
  render::SubjectBounds body;
  SceneStatic one{{m_looked_at}};
  Frame only;
  only.number = frame.number;
  only.bodies = {frame.bodies[static_cast<std::size_t>(m_body)]};
  if (Status status = body.include(one, only); !status)
    return status.error();
  if (!plan.placed) {
    const Result<render::Camera> framed =
        render::frame_camera(plan, m_up, m_bounds, m_size, render::Framing::still, 0.0);
    if (!framed)
      return framed.error();
    plan.placed = render::PlacedCamera{framed->eye, body.centre(), {}};
  }
  plan.placed->target = body.centre();
  return plan;
}

} // namespace wry::pipeline
