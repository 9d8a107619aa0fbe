#include "sim/mpm/seeding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace wry::mpm {

namespace {

struct Lattice {
  std::array<double, 3> counts; ///< whole numbers
  Vec3 spacing;                 ///< [m]
};

Lattice fit_lattice(const Vec3& low, const Vec3& high, const SeedSettings& settings) {
  const double wanted = settings.cell / std::cbrt(settings.particles_per_cell);
  Lattice lattice;
  for (int axis = 0; axis < 3; ++axis) {
    const double size = high[axis] - low[axis];
    lattice.counts[static_cast<std::size_t>(axis)] = std::max(1.0, std::round(size / wanted));
    lattice.spacing[axis] = size / lattice.counts[static_cast<std::size_t>(axis)];
  }
  return lattice;
}

} // namespace

double lattice_size(const Vec3& low, const Vec3& high, const SeedSettings& settings) {
  const Lattice lattice = fit_lattice(low, high, settings);
  return lattice.counts[0] * lattice.counts[1] * lattice.counts[2];
}

Result<Seeds> fill(const Vec3& low, const Vec3& high, const std::function<bool(const Vec3&)>& inside,
                   const SeedSettings& settings) {
  const Lattice lattice = fit_lattice(low, high, settings);
  std::vector<Vec3> points;
  std::mt19937_64 random(settings.seed);
  // Of our own, since the distributions of the standard library differ between implementations.
  const auto next = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const bool jitter = settings.sampling == Sampling::jittered;
  for (double x = 0; x < lattice.counts[0]; ++x) {
    for (double y = 0; y < lattice.counts[1]; ++y) {
      for (double z = 0; z < lattice.counts[2]; ++z) {
        Vec3 place(x, y, z);
        place += jitter ? Vec3(next(), next(), next()) : Vec3::Constant(0.5);
        const Vec3 point = low + place.cwiseProduct(lattice.spacing);
        if (!inside(point))
          continue;
        if (settings.most > 0 && points.size() == settings.most)
          return make_error(
              ErrorCode::out_of_memory,
              "more than {} particles of {:.3g} per cell of {:.4g} m; try a larger mpm.cell_size or fewer "
              "particles_per_cell",
              settings.most, settings.particles_per_cell, settings.cell);
        points.push_back(point);
      }
    }
  }
  if (points.empty())
    return make_error(ErrorCode::bad_input,
                      "no particle fits between ({:.4g}, {:.4g}, {:.4g}) and ({:.4g}, {:.4g}, {:.4g}) m: they stand "
                      "{:.4g} m apart; try a smaller mpm.cell_size or more particles_per_cell",
                      low.x(), low.y(), low.z(), high.x(), high.y(), high.z(), lattice.spacing.maxCoeff());
  Seeds seeds;
  seeds.positions.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    seeds.positions.row(static_cast<Eigen::Index>(i)) = points[i];
  seeds.volume = lattice.spacing.prod();
  return seeds;
}

} // namespace wry::mpm
