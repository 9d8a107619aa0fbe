#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sim/mpm/boundaries.h"
#include "sim/mpm/grid.h"

namespace wry::mpm {

/// Four floats that are added together: velocity times activity, and activity.
typedef float Quad __attribute__((vector_size(16)));

/// What grains of a block see in an update.
struct FlowField {
  static constexpr int SIDE = HALO_SIDE;
  static constexpr int NODES = SIDE * SIDE * SIDE;

  alignas(64) Quad flow[NODES];
  alignas(64) float density[NODES]; ///< share of rho_0
  BlockCoord coord;
  Vec3 origin;                ///< of the block's first node, in cells
  float least_density = 0.0F; ///< of all nodes
  std::vector<NearWall> walls;
  const Boundaries* boundaries = nullptr;
  Vec3 gravity;
  double cell = 0.0, dt = 0.0;

  /// Weights of quadratic B-splines along an axis, and the first node's distance.
  struct Axis {
    float w[3], d[3]; ///< weight, and weight times node minus point [cells]
  };
  /// The first of three nodes along an axis, counted in the halo. Nothing but that count knows the block, so that a
  /// grain's answer is the same, bit for bit, whichever block it is sorted into.
  static int first_node(double along, double block_origin, Axis& axis) {
    const double base = std::floor(along - 0.5);
    const float f = static_cast<float>(along - base);
    const float w[3] = {0.5F * (1.5F - f) * (1.5F - f), 0.75F - (f - 1.0F) * (f - 1.0F),
                        0.5F * (f - 0.5F) * (f - 0.5F)};
    for (int i = 0; i < 3; ++i) {
      axis.w[i] = w[i];
      axis.d[i] = w[i] * (static_cast<float>(i) - f);
    }
    return std::clamp(static_cast<int>(base - block_origin) + 1, 0, SIDE - 3); // the halo begins a node earlier
  }
  int stencil(const Vec3& point, std::array<Axis, 3>& axes) const {
    int first = 0;
    for (int k = 0; k < 3; ++k)
      first = first * SIDE + first_node(point[k] / cell, origin[k], axes[static_cast<std::size_t>(k)]);
    return first;
  }
  /// Sum of weights times density, as a share of rho_0.
  double density_at(const Vec3& point) const {
    std::array<Axis, 3> a;
    const int first = stencil(point, a);
    return density_in(a, first);
  }
  double density_in(const std::array<Axis, 3>& a, int first) const {
    float sum = 0.0F;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const float* row = density + first + (i * SIDE + j) * SIDE;
        sum += a[0].w[i] * a[1].w[j] * (a[2].w[0] * row[0] + a[2].w[1] * row[1] + a[2].w[2] * row[2]);
      }
    }
    return sum;
  }
  /// Velocity and its gradient as APIC sees it, both by least squares over the active nodes (S7). False where the
  /// matter is thinner than `least`, or no node is active.
  bool motion_at(const Vec3& point, double least, Vec3& velocity, Mat3& gradient) const {
    std::array<Axis, 3> a;
    const int first = stencil(point, a);
    // Where every node is denser, so is their mean; a little more, for its rounding.
    if (least_density < 1.0001 * least && density_in(a, first) < least)
      return false;
    // Axis by axis, since weights are products.
    Quad sum = {}, along[3] = {};
    for (int i = 0; i < 3; ++i) {
      Quad plain_y = {}, slope_y = {}, slope_z = {};
      for (int j = 0; j < 3; ++j) {
        const Quad* row = flow + first + (i * SIDE + j) * SIDE;
        const Quad plain = a[2].w[0] * row[0] + a[2].w[1] * row[1] + a[2].w[2] * row[2];
        slope_z += a[1].w[j] * (a[2].d[0] * row[0] + a[2].d[1] * row[1] + a[2].d[2] * row[2]);
        plain_y += a[1].w[j] * plain;
        slope_y += a[1].d[j] * plain;
      }
      sum += a[0].w[i] * plain_y;
      along[0] += a[0].d[i] * plain_y;
      along[1] += a[0].w[i] * slope_y;
      along[2] += a[0].w[i] * slope_z;
    }
    if (!(sum[3] > 1e-6F))
      return false;
    const double inverse = 1.0 / static_cast<double>(sum[3]);
    velocity = Vec3(sum[0], sum[1], sum[2]) * inverse;
    const Vec3 centre = Vec3(along[0][3], along[1][3], along[2][3]) * inverse;
    for (int k = 0; k < 3; ++k)
      gradient.col(k) = Vec3(along[k][0], along[k][1], along[k][2]) * inverse - centre[k] * velocity;
    gradient *= 4.0 / cell; // the second moment of a full stencil is h^2 / 4
    if (sum[3] < 0.999F)
      gradient *= shrunk(a, first, inverse, centre);
    return true;
  }

private:
  /// (h^2/4) K^-1 of a stencil with inactive nodes, K their second moment about their mean; its inverse is damped where
  /// the nodes lie in a plane.
  Mat3 shrunk(const std::array<Axis, 3>& a, int first, double inverse, const Vec3& centre) const {
    float squared[3][3]; // weight times squared distance, per axis and node
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t at = 0; at < 3; ++at) {
        const float weight = a[axis].w[at], moment = a[axis].d[at];
        squared[axis][at] = weight > 1e-9F ? moment * moment / weight : 0.0F;
      }
    }
    float xx = 0.0F, yy = 0.0F, zz = 0.0F, yz = 0.0F, xz = 0.0F, xy = 0.0F;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const Quad* row = flow + first + (i * SIDE + j) * SIDE;
        float plain = 0.0F, slope = 0.0F, curve = 0.0F;
        for (int k = 0; k < 3; ++k) {
          const float active = row[k][3];
          plain += active * a[2].w[k];
          slope += active * a[2].d[k];
          curve += active * squared[2][k];
        }
        xx += squared[0][i] * a[1].w[j] * plain;
        yy += a[0].w[i] * squared[1][j] * plain;
        zz += a[0].w[i] * a[1].w[j] * curve;
        yz += a[0].w[i] * a[1].d[j] * slope;
        xz += a[0].d[i] * a[1].w[j] * slope;
        xy += a[0].d[i] * a[1].d[j] * plain;
      }
    }
    Mat3 K;
    K << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    K = K * inverse - centre * centre.transpose();
    const Mat3 damped = 4.0 * K + 0.05 * Mat3::Identity();
    Mat3 adjugate;
    adjugate.row(0) = damped.col(1).cross(damped.col(2));
    adjugate.row(1) = damped.col(2).cross(damped.col(0));
    adjugate.row(2) = damped.col(0).cross(damped.col(1));
    return adjugate / damped.col(0).dot(damped.col(1).cross(damped.col(2)));
  }
};

} // namespace wry::mpm
