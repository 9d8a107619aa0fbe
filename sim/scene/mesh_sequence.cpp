#include "sim/scene/mesh_sequence.h"

#include <algorithm>

namespace wry::scene {

MeshSequence::Place MeshSequence::place_of(double time) const {
  const double last = static_cast<double>(samples.size() - 1);
  const double place = std::clamp((time - first_time) / interval, 0.0, last);
  const auto before = static_cast<std::size_t>(place);
  return {before, place - static_cast<double>(before)};
}

Points MeshSequence::at(double time) const {
  const Place place = place_of(time);
  if (place.part == 0.0)
    return samples[place.before];
  return (1.0 - place.part) * samples[place.before] + place.part * samples[place.before + 1];
}

Points MeshSequence::velocities_at(double time) const {
  const Place place = place_of(time);
  if (time < first_time || place.before + 1 >= samples.size())
    return Points::Zero(samples.front().rows(), 3);
  return (samples[place.before + 1] - samples[place.before]) / interval;
}

} // namespace wry::scene
