#include "sim/mpm/particles.h"

namespace wry::mpm {

namespace {

double initial_value(Channel channel, int component) {
  const bool on_diagonal = channel == Channel::deformation && component % 4 == 0;
  const bool real_part = channel == Channel::frame && component == 0;
  const bool isotropic = channel == Channel::second_moment && component < 3;
  if (on_diagonal || real_part)
    return 1.0;
  return isotropic ? 1.0 / 3.0 : channel_info(channel).initial;
}

} // namespace

template <class Scalar> ParticleSet<Scalar>::ParticleSet(const std::vector<Channel>& channels) {
  for (int i = 0; i <= static_cast<int>(LAST_BASE_CHANNEL); ++i)
    m_has[i] = true;
  for (const Channel channel : channels)
    m_has[static_cast<int>(channel)] = true;
}

template <class Scalar> void ParticleSet<Scalar>::resize(std::size_t tiles) {
  const std::size_t before = m_tiles;
  m_tiles = tiles;
  for (int i = 0; i < CHANNEL_COUNT; ++i) {
    if (!m_has[i])
      continue;
    const Channel channel = static_cast<Channel>(i);
    const int components = channel_info(channel).components;
    m_values[i].resize(tiles * components * WIDTH);
    for (std::size_t tile = before; tile < tiles; ++tile) {
      for (int entry = 0; entry < components * WIDTH; ++entry)
        m_values[i][tile * components * WIDTH + entry] = static_cast<Scalar>(initial_value(channel, entry / WIDTH));
    }
  }
}

template <class Scalar> std::size_t ParticleSet<Scalar>::bytes_per_particle() const {
  std::size_t bytes = 0;
  for (int i = 0; i < CHANNEL_COUNT; ++i)
    bytes += m_has[i] ? CHANNELS[i].components * sizeof(Scalar) : 0;
  return bytes;
}

template class ParticleSet<float>;
template class ParticleSet<double>;

std::size_t bytes_per_particle(const std::vector<Channel>& channels, std::size_t scalar_bytes) {
  return scalar_bytes == sizeof(float) ? ParticleSet<float>(channels).bytes_per_particle()
                                       : ParticleSet<double>(channels).bytes_per_particle();
}

} // namespace wry::mpm
