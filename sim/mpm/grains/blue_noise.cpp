#include "sim/mpm/grains/blue_noise.h"

#include <cmath>
#include <unordered_map>
#include <vector>

#include "sim/mpm/grains/dice.h"
#include "sim/mpm/grid.h"

namespace wry::mpm {

namespace {

constexpr int CANDIDATES = 6;

/// Points by the cells of a lattice, for distances up to one cell.
class NearPoints {
public:
  NearPoints(double cell, std::size_t count)
      : m_cell(cell) {
    m_cells.reserve(count);
  }

  void add(const Vec3& point) { m_cells[cell_of(point)].push_back(point); }

  /// Square of the distance to the nearest point, at most a cell's.
  double distance_squared(const Vec3& point) const {
    const BlockCoord middle = cell_of(point);
    double least = m_cell * m_cell;
    for (std::int64_t x = -1; x <= 1; ++x) {
      for (std::int64_t y = -1; y <= 1; ++y) {
        for (std::int64_t z = -1; z <= 1; ++z) {
          const auto found = m_cells.find({middle.x + x, middle.y + y, middle.z + z});
          if (found == m_cells.end())
            continue;
          for (const Vec3& other : found->second)
            least = std::min(least, (other - point).squaredNorm());
        }
      }
    }
    return least;
  }

private:
  BlockCoord cell_of(const Vec3& p) const {
    return {static_cast<std::int64_t>(std::floor(p[0] / m_cell)), static_cast<std::int64_t>(std::floor(p[1] / m_cell)),
            static_cast<std::int64_t>(std::floor(p[2] / m_cell))};
  }
  double m_cell;
  std::unordered_map<BlockCoord, std::vector<Vec3>, BlockCoordHash> m_cells;
};

} // namespace

Points spread_in_particles(const Points& particles, double particle_volume, int per_particle, std::uint64_t seed) {
  const double side = std::cbrt(particle_volume);
  const auto count = static_cast<std::size_t>(particles.rows()) * static_cast<std::size_t>(per_particle);
  NearPoints near(std::cbrt(particle_volume / per_particle), count);
  Points points(static_cast<Eigen::Index>(count), 3);
  Dice dice(seed);
  // All first points, then all second ones: early points see all of space.
  for (int k = 0; k < per_particle; ++k) {
    for (Eigen::Index i = 0; i < particles.rows(); ++i) {
      Vec3 best = Vec3::Zero();
      double furthest = -1.0;
      for (int c = 0; c < CANDIDATES; ++c) {
        const Vec3 offset(dice.uniform() - 0.5, dice.uniform() - 0.5, dice.uniform() - 0.5);
        const Vec3 candidate = particles.row(i).transpose() + side * offset;
        const double distance = near.distance_squared(candidate);
        if (distance > furthest) {
          furthest = distance;
          best = candidate;
        }
      }
      near.add(best);
      points.row(i * per_particle + k) = best.transpose();
    }
  }
  return points;
}

} // namespace wry::mpm
