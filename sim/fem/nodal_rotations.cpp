#include "sim/fem/nodal_rotations.h"

#include <cmath>

#include <Eigen/Dense>
#include <Eigen/SVD>

namespace wry::fem {

namespace {

Mat3 nearest_rotation(const Mat3& deformation) {
  if (!deformation.allFinite())
    return Mat3::Identity();
  const Eigen::JacobiSVD<Mat3> svd(deformation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0.0)
    u.col(2) = -u.col(2);
  return u * svd.matrixV().transpose();
}

} // namespace

Mat3 rotation_matrix(const Eigen::Ref<const Eigen::RowVector4d>& q) {
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

Eigen::RowVector4d turned(const Eigen::Ref<const Eigen::RowVector4d>& quaternion,
                          const Eigen::Ref<const Eigen::RowVector3d>& increment) {
  const Vec3 axis = quaternion.tail<3>().transpose();
  const Vec3 half = 0.5 * increment.transpose();
  Eigen::RowVector4d result;
  result[0] = quaternion[0] - half.dot(axis);
  result.tail<3>() = (axis + quaternion[0] * half + half.cross(axis)).transpose();
  return result.normalized();
}

void estimate_node_rotations(const FemScene& scene, const Quaternions& rotations, const Trial& trial,
                             std::vector<Mat3>& out) {
  out.assign(scene.model.layout.node_count(), Mat3::Zero());
  for (std::size_t body = 0; body < scene.model.bodies.size(); ++body) {
    const BodyNodes& nodes = scene.model.bodies[body];
    if (!nodes.micropolar)
      scene.elements[body]->add_deformations(trial.positions, out);
    for (int node = nodes.first_node; node < nodes.first_node + nodes.node_count; ++node)
      out[node] = nodes.micropolar ? rotation_matrix(turned(rotations.row(node), trial.increments.row(node)))
                                   : nearest_rotation(out[node]);
  }
}

void place_midpoint_rotations(const FemModel& model, Quaternions& rotations) {
  for (const BodyNodes& body : model.bodies) {
    for (const BodyNodes::Midpoint& middle : body.midpoints)
      rotations.row(middle.node) = (rotations.row(middle.ends[0]) + rotations.row(middle.ends[1])).normalized();
  }
}

} // namespace wry::fem
