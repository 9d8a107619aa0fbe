#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "sim/base/types.h"

namespace wry::mpm {

/// Random numbers that are the same on every machine (SplitMix64).
class Dice {
public:
  explicit Dice(std::uint64_t seed)
      : m_state(seed) {}

  /// In [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  /// Normally distributed.
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }
  /// A unit vector, all directions alike.
  Vec3 direction() {
    const double z = 2.0 * uniform() - 1.0, angle = 2.0 * std::numbers::pi * uniform();
    const double r = std::sqrt(1.0 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }

private:
  std::uint64_t next() {
    m_state += 0x9E3779B97F4A7C15u;
    std::uint64_t z = m_state;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  std::uint64_t m_state;
};

} // namespace wry::mpm
