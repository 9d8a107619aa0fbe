#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace wry {

using Vec3 = Eigen::Vector3d;
using Vec4 = Eigen::Vector4d;
using Mat3 = Eigen::Matrix3d;

/// n x 3, a row per point.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// n x 4, a row per unit quaternion, (w, x, y, z). Signs are never canonicalised.
using Quaternions = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;
/// n x 3 vertex indices, counter-clockwise seen from outside.
using Triangles = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// n x 4 vertex indices; (x1-x0) x (x2-x0) . (x3-x0) > 0.
using Tets = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 4, Eigen::RowMajor>;

} // namespace wry
