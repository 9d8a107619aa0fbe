#include "render/burial.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>

namespace wry::render {
namespace {

/// Share of a cell that must be matter for it to hide what is behind it.
constexpr double FULL = 0.1;
/// Grains that a full cell holds, about.
constexpr double GRAINS_PER_CELL = 10.0;
/// Full cells above what is left out: through two of them some rays pass, and a shadow is seen to miss.
constexpr int LAYERS = 3;
constexpr int CASTING_LAYERS = 3;
constexpr std::size_t CELLS_MAX = std::size_t{1} << 26;
constexpr std::size_t FEWEST = 2000; ///< below that nothing is gained

/// A box of cells about all grains, with a margin of cells so that what is beyond the box is known to be empty.
class CellGrid {
public:
  CellGrid(const GrainCloud& cloud, double cell, int margin)
      : m_cell(static_cast<float>(cell)) {
    Eigen::AlignedBox3f box;
    for (const DrawGrain& grain : cloud.grains)
      box.extend(Eigen::Vector3f(grain.centre[0], grain.centre[1], grain.centre[2]));
    while (true) {
      m_low = box.min() - Eigen::Vector3f::Constant((static_cast<float>(margin) + 0.5f) * m_cell);
      const Eigen::Vector3f sides = (box.sizes() / m_cell).array() + static_cast<float>(2 * margin + 2);
      if (static_cast<double>(sides.x()) * sides.y() * sides.z() < static_cast<double>(CELLS_MAX)) {
        m_sides = sides.cast<int>();
        break;
      }
      m_cell *= 1.5f;
    }
  }

  std::size_t count() const {
    return static_cast<std::size_t>(m_sides.x()) * static_cast<std::size_t>(m_sides.y()) *
           static_cast<std::size_t>(m_sides.z());
  }
  float cell() const { return m_cell; }
  const Eigen::Vector3i& sides() const { return m_sides; }
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(m_sides.y()) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(m_sides.x()) +
           static_cast<std::size_t>(x);
  }
  std::size_t index_of(const std::array<float, 3>& p) const {
    const auto place = [&](int a) {
      return std::clamp(static_cast<int>((p[static_cast<std::size_t>(a)] - m_low[a]) / m_cell), 0, m_sides[a] - 1);
    };
    return index(place(0), place(1), place(2));
  }
  std::array<float, 3> centre(int x, int y, int z) const {
    const auto at = [&](int a, int i) { return m_low[a] + (static_cast<float>(i) + 0.5f) * m_cell; };
    return {at(0, x), at(1, y), at(2, z)};
  }

private:
  float m_cell;
  Eigen::Vector3f m_low;
  Eigen::Vector3i m_sides;
};

/// Keeps the cells whose 26 neighbours are all kept: the least along x, then y, then z.
void erode(const CellGrid& grid, std::vector<std::uint8_t>& kept) {
  const Eigen::Vector3i n = grid.sides();
  const std::array<std::size_t, 3> strides = {1, static_cast<std::size_t>(n.x()),
                                              static_cast<std::size_t>(n.x()) * static_cast<std::size_t>(n.y())};
  std::vector<std::uint8_t> source(kept.size());
  for (int axis = 0; axis < 3; ++axis) {
    source = kept;
    const std::size_t stride = strides[static_cast<std::size_t>(axis)];
    for (std::size_t i = 0; i < kept.size(); ++i)
      kept[i] = i >= stride && i + stride < kept.size() ? source[i] & source[i - stride] & source[i + stride]
                                                        : std::uint8_t{0};
  }
}

bool touches_kept(const CellGrid& grid, const std::vector<std::uint8_t>& buried, int x, int y, int z) {
  return !buried[grid.index(x - 1, y, z)] || !buried[grid.index(x + 1, y, z)] || !buried[grid.index(x, y - 1, z)] ||
         !buried[grid.index(x, y + 1, z)] || !buried[grid.index(x, y, z - 1)] || !buried[grid.index(x, y, z + 1)];
}

} // namespace

namespace {

/// Cells that hold enough to hide what is behind them, and those under the floor.
std::vector<std::uint8_t> full_cells(const GrainCloud& cloud, const CellGrid& grid, const std::optional<Floor>& floor) {
  const double needed = FULL * std::pow(static_cast<double>(grid.cell()), 3) / cloud.mean_volume;
  std::vector<std::uint32_t> held(grid.count(), 0);
  for (const DrawGrain& grain : cloud.grains)
    ++held[grid.index_of(grain.centre)];
  std::vector<std::uint8_t> full(grid.count());
  for (std::size_t i = 0; i < full.size(); ++i)
    full[i] = held[i] >= needed ? 1 : 0;
  if (!floor)
    return full;
  for (int z = 0; z < grid.sides().z(); ++z) {
    for (int y = 0; y < grid.sides().y(); ++y) {
      for (int x = 0; x < grid.sides().x(); ++x) {
        const std::array<float, 3> c = grid.centre(x, y, z);
        if (floor->up.dot(Eigen::Vector3f(c[0], c[1], c[2])) < floor->height + 0.5f * grid.cell())
          full[grid.index(x, y, z)] = 1;
      }
    }
  }
  return full;
}

std::vector<std::uint32_t> unburied(const GrainCloud& cloud, const CellGrid& grid,
                                    const std::vector<std::uint8_t>& buried) {
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < cloud.grains.size(); ++i) {
    if (!buried[grid.index_of(cloud.grains[i].centre)])
      kept.push_back(i);
  }
  return kept;
}

Darkness darkness_of(const CellGrid& grid, const std::vector<std::uint8_t>& buried) {
  Darkness darkness;
  darkness.cell = grid.cell();
  for (int z = 1; z + 1 < grid.sides().z(); ++z) {
    for (int y = 1; y + 1 < grid.sides().y(); ++y) {
      for (int x = 1; x + 1 < grid.sides().x(); ++x) {
        if (buried[grid.index(x, y, z)] && touches_kept(grid, buried, x, y, z))
          darkness.centres.push_back(grid.centre(x, y, z));
      }
    }
  }
  return darkness;
}

} // namespace

Exposure exposed_grains(const GrainCloud& cloud, const std::optional<Floor>& floor) {
  Exposure exposure;
  const std::size_t count = cloud.grains.size();
  const auto all = [&] {
    exposure.visible.resize(count);
    std::iota(exposure.visible.begin(), exposure.visible.end(), 0U);
    return exposure;
  };
  if (count < FEWEST || !(cloud.mean_volume > 0.0))
    return all();
  const double cell = std::cbrt(GRAINS_PER_CELL * cloud.mean_volume / 0.5);
  const int for_length = std::max(0, static_cast<int>(std::ceil(static_cast<double>(cloud.reach) / cell - 1.0)));
  const CellGrid grid(cloud, cell, LAYERS + for_length + 1);
  std::vector<std::uint8_t> buried = full_cells(cloud, grid, floor);
  for (int layer = 0; layer < CASTING_LAYERS + for_length; ++layer)
    erode(grid, buried);
  exposure.casting = unburied(cloud, grid, buried);
  exposure.beneath_casting = darkness_of(grid, buried);
  for (int layer = CASTING_LAYERS; layer < LAYERS; ++layer)
    erode(grid, buried);
  exposure.visible = unburied(cloud, grid, buried);
  exposure.beneath = darkness_of(grid, buried);
  return exposure.has_buried() ? exposure : all();
}

} // namespace wry::render
