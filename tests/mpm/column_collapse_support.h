#pragma once

#include <optional>

namespace wry::mpm::test {

/// A cylinder of sand that is let go on a floor: a quarter of it, between two smooth planes.
struct ColumnCollapse {
  double aspect = 1.0;              ///< height over radius
  int cells = 12;                   ///< in the radius, which is .12 m
  double friction_degrees = 31.0;   ///< of the sand
  std::optional<double> floor = {}; ///< Coulomb friction of the floor; absent: it holds what touches it
};

struct RunOut {
  double front = 0.0;     ///< (R - R0) / R0 where the deposit ends
  double most_mass = 0.0; ///< the same where 98 % of the mass is behind: inside the heap, the more so the lower it is
  double height = 0.0;    ///< of the deposit over R0
};

/// Runs it until it rests and measures it. The front is where the mean thickness of rings a cell wide, linear between
/// their middles, falls below half a layer of particles for the first time: experiments measure it at a grain's.
RunOut run_out(const ColumnCollapse& column);

} // namespace wry::mpm::test
