#pragma once

#include <vector>

#include "sim/base/types.h"

namespace wry::scene {

/// The vertices of a mesh over time: straight between samples; before the first and after the last they stand still.
struct MeshSequence {
  std::vector<Points> samples; ///< at least one; of all vertices [m]
  double first_time = 0.0;     ///< of the first sample [s]
  double interval = 1.0;       ///< from sample to sample, positive [s]

  Points at(double time) const;
  /// Of the vertices [m/s]; at a sample, that of the stretch which begins there.
  Points velocities_at(double time) const;

private:
  /// The sample before a time, and how much of the way to the next one is done.
  struct Place {
    std::size_t before;
    double part;
  };
  Place place_of(double time) const;
};

} // namespace wry::scene
