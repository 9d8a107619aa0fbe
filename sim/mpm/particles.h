#pragma once

#include <cstdint>
#include <vector>

#include "sim/base/aligned.h"
#include "sim/mpm/channels.h"

namespace wry::mpm {

/// The particles of one body: one material, one mass, one rest volume. Channels are allocated on demand, laid out as
/// channels.h says. Particles of one block of the grid stand together in whole tiles (see BlockRun), so that a tile
/// never belongs to two blocks and, with that, never to two threads.
template <class Scalar> class ParticleSet {
public:
  static constexpr int WIDTH = TILE_WIDTH<Scalar>;

  /// With the base channels and these.
  explicit ParticleSet(const std::vector<Channel>& channels = {});

  /// Tiles of every channel, new ones filled with the channels' initial values.
  void resize(std::size_t tiles);
  std::size_t tiles() const { return m_tiles; }

  bool has(Channel channel) const { return m_has[static_cast<int>(channel)]; }
  /// The channel's first tile, nullptr when there is none.
  Scalar* channel(Channel channel) { return has(channel) ? m_values[static_cast<int>(channel)].data() : nullptr; }
  const Scalar* channel(Channel channel) const {
    return has(channel) ? m_values[static_cast<int>(channel)].data() : nullptr;
  }
  Scalar* tile(Channel which, std::size_t tile) {
    Scalar* first = channel(which);
    return first ? first + tile * channel_info(which).components * WIDTH : nullptr;
  }
  const Scalar* tile(Channel which, std::size_t tile) const {
    return const_cast<ParticleSet*>(this)->tile(which, tile);
  }

  /// One component of one particle, by its place (tile * WIDTH + lane).
  Scalar& at(Channel which, std::size_t place, int component) {
    return m_values[static_cast<int>(which)]
                   [((place / WIDTH) * channel_info(which).components + component) * WIDTH + place % WIDTH];
  }
  Scalar at(Channel which, std::size_t place, int component) const {
    return const_cast<ParticleSet*>(this)->at(which, place, component);
  }

  /// The sum of the declared channels.
  std::size_t bytes_per_particle() const;

private:
  std::size_t m_tiles = 0;
  bool m_has[CHANNEL_COUNT] = {};
  AlignedVector<Scalar> m_values[CHANNEL_COUNT];
};

extern template class ParticleSet<float>;
extern template class ParticleSet<double>;

/// Bytes that these channels beyond the base ones, and the base ones, take per particle.
std::size_t bytes_per_particle(const std::vector<Channel>& channels, std::size_t scalar_bytes);

} // namespace wry::mpm
