#include "pipeline/assets/motion_import.h"

#include <cmath>
#include <span>

#include <Eigen/Geometry>

#include "pipeline/assets/import_process.h"
#include "pipeline/assets/import_protocol.h"
#include "sim/scene/transform.h"

namespace wry::pipeline {

namespace {

/// A transform without its even scale, in metres and the scene's axes. Error: bad_input when it is no similarity.
Result<scene::Pose> pose_of(const RawTransform& raw, const Mat3& upright, double metres_per_unit) {
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(raw.data());
  if (!matrix.allFinite())
    return make_error(ErrorCode::bad_input, "a transform is not finite");
  const Mat3 linear = matrix.topLeftCorner<3, 3>();
  const double determinant = linear.determinant();
  const double scale = std::cbrt(determinant);
  constexpr double TOLERANCE = 1e-3;
  if (!(scale > 0.0) ||
      (linear.transpose() * linear / (scale * scale) - Mat3::Identity()).cwiseAbs().maxCoeff() > TOLERANCE)
    return make_error(ErrorCode::bad_input, "it is stretched, sheared or mirrored; only rigid motion is possible");
  const Eigen::JacobiSVD<Mat3> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
  scene::Pose pose;
  pose.rotation = upright * svd.matrixU() * svd.matrixV().transpose() * upright.transpose();
  pose.translation = metres_per_unit * (upright * matrix.topRightCorner<3, 1>());
  return pose;
}

} // namespace

Result<scene::Motion> ImportedMotion::relative_motion() const {
  if (samples.empty())
    return make_error(ErrorCode::bad_input, "nothing moves it in the file; export its animation, or give keys");
  std::vector<scene::PoseSample> relative;
  for (const scene::PoseSample& sample : samples) {
    const Mat3 rotation = sample.pose.rotation * rest.rotation.transpose();
    relative.push_back({sample.time, {rotation, sample.pose.translation - rotation * rest.translation}});
  }
  return scene::Motion::through_samples(relative);
}

Result<ImportedMotion> import_motion(const std::string& path, const MeshImportOptions& options) {
  if (Status status = check_mesh_path(path); !status)
    return status.error();
  const Result<std::string> answer =
      run_import_process({options.program, path, options.node, ImportWhat::motion, options.limits});
  if (!answer)
    return answer.error();
  const Result<RawMesh> raw = decode_answer(std::as_bytes(std::span(answer->data(), answer->size())));
  const auto in_file = [&](const Error& error) {
    return Error{error.code, fmt::format("{}: node '{}': {}", path, options.node, error.message)};
  };
  if (!raw)
    return in_file(raw.error());
  const Mat3 upright = scene::up_rotation(options.up, options.scene_up);
  ImportedMotion motion;
  const Result<scene::Pose> rest = pose_of(raw->motion.rest, upright, options.metres_per_unit);
  if (!rest)
    return in_file(rest.error());
  motion.rest = *rest;
  if (raw->motion.camera_fov > 0.0)
    motion.camera_fov = raw->motion.camera_fov;
  for (std::size_t i = 0; i < raw->motion.times.size(); ++i) {
    const Result<scene::Pose> pose = pose_of(raw->motion.transforms[i], upright, options.metres_per_unit);
    if (!pose)
      return in_file(pose.error());
    motion.samples.push_back({raw->motion.times[i], *pose});
  }
  return motion;
}

} // namespace wry::pipeline
