#pragma once

#include <vector>

#include "sim/fem/fem_scene.h"

namespace wry::fem {

/// (w, x, y, z) -> matrix, material to world.
Mat3 rotation_matrix(const Eigen::Ref<const Eigen::RowVector4d>& quaternion);

/// The Cayley update of eq 26: q0 turned by the world-frame increment a, unit length, sign kept.
Eigen::RowVector4d turned(const Eigen::Ref<const Eigen::RowVector4d>& quaternion,
                          const Eigen::Ref<const Eigen::RowVector3d>& increment);

/// How far each node has turned since rest: the microrotation where there is one, else the rotation of the mean
/// deformation around the node.
void estimate_node_rotations(const FemScene& scene, const Quaternions& rotations, const Trial& trial,
                             std::vector<Mat3>& out);

/// Gives the midpoints of quadratic elements the mean rotation of their edge's ends.
void place_midpoint_rotations(const FemModel& model, Quaternions& rotations);

} // namespace wry::fem
