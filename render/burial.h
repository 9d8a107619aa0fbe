#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "render/grain_cloud.h"

namespace wry::render {

/// Cells that stand in for what lies beneath, to close gaps.
struct Darkness {
  std::vector<std::array<float, 3>> centres; ///< [m]
  float cell = 0.f;                          ///< side [m]
};

/// What of a heap of grains can be seen from outside at all.
struct Exposure {
  std::vector<std::uint32_t> visible; ///< grains that stay, in order
  Darkness beneath;
  std::vector<std::uint32_t> casting; ///< grains that can be the first in the light's way: fewer
  Darkness beneath_casting;
  bool has_buried() const { return !beneath.centres.empty(); }
};

/// A floor that nobody looks through from below.
struct Floor {
  Eigen::Vector3f up = Eigen::Vector3f::UnitY();
  float height = 0.f; ///< along up [m]
};

/// Finds the grains that lie deeper in a heap than light and eye can reach: cells of a grid that are full of matter,
/// beneath more full cells and farther below the surface than a grain is long. Loose grains all stay. What is below the
/// floor counts as full.
Exposure exposed_grains(const GrainCloud& cloud, const std::optional<Floor>& floor = std::nullopt);

} // namespace wry::render
