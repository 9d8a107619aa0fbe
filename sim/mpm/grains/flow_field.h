#pragma once

#include <algorithm>
#include <bitset>
#include <cmath>
#include <vector>

#include "sim/mpm/boundaries.h"
#include "sim/mpm/grains/grain_batch.h"

namespace wry::mpm {

/// What grains of a block see in an update.
struct FlowField {
  FlowNodes nodes;
  BlockCoord coord;
  std::vector<NearWall> walls;
  const Boundaries* boundaries = nullptr;
  Vec3 gravity;
  double dt = 0.0;
  double reach = 0.0; ///< at which the largest grain meets an obstacle [m]

  Vec3 origin() const { return {nodes.origin[0], nodes.origin[1], nodes.origin[2]}; }

  /// Which walls a grain of this radius [m] may meet at a place in cells from the block's first node: asked once for
  /// each cell.
  WallSet walls_at(const Vec3& local, double radius) {
    if (walls.empty())
      return {};
    int cell = 0;
    Vec3 middle;
    for (int axis = 0; axis < 3; ++axis) {
      const double lower = std::floor(local[axis]);
      if (!(lower >= -1.0 && lower < CELLS - 1.0))
        return WallSet::all();
      cell = cell * CELLS + static_cast<int>(lower) + 1;
      middle[axis] = lower + 0.5;
    }
    const auto place = static_cast<std::size_t>(cell);
    if (!m_asked[place]) {
      constexpr double CORNER = 0.8661; // of a cell, from its middle
      m_asked.set(place);
      m_near[place] = boundaries->walls_within(walls, (origin() + middle) * nodes.cell, reach + CORNER * nodes.cell);
    }
    const Boundaries::WallsWithin& near = m_near[place];
    if (near.which.is_empty())
      return {};
    const double clear = near.least_distance - radius - 1e-9 * nodes.cell;
    const bool is_clear = clear > 0.0 && (local - middle).squaredNorm() * nodes.cell * nodes.cell < clear * clear;
    return is_clear ? WallSet() : near.which;
  }

  /// Sum of quadratic B-splines times density, as a share of rho_0.
  double density_at(const Vec3& point) const {
    float weight[3][3];
    int first = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double along = point[axis] / nodes.cell;
      const double base = std::floor(along - 0.5);
      const float f = static_cast<float>(along - base);
      weight[axis][0] = 0.5F * (1.5F - f) * (1.5F - f);
      weight[axis][1] = 0.75F - (f - 1.0F) * (f - 1.0F);
      weight[axis][2] = 0.5F * (f - 0.5F) * (f - 0.5F);
      const int in_halo = static_cast<int>(base - nodes.origin[axis]) + 1; // the halo begins a node earlier
      first = first * HALO_SIDE + std::clamp(in_halo, 0, HALO_SIDE - 3);
    }
    float sum = 0.0F;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const float* row = nodes.density + first + (i * HALO_SIDE + j) * HALO_SIDE;
        sum += weight[0][i] * weight[1][j] * (weight[2][0] * row[0] + weight[2][1] * row[1] + weight[2][2] * row[2]);
      }
    }
    return sum;
  }

private:
  /// Along each axis, from -1 on: what grains of the block reach before they are sorted.
  static constexpr int CELLS = 7;
  std::bitset<CELLS * CELLS * CELLS> m_asked;
  std::array<Boundaries::WallsWithin, CELLS * CELLS * CELLS> m_near;
};

} // namespace wry::mpm
