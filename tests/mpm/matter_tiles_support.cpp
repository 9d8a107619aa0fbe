#include "tests/mpm/matter_tiles_support.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace wry::mpm::test {

namespace {

constexpr int ORDER[6][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {2, 0}, {0, 1}};

/// Channels of whole tiles, by component and particle.
template <class T> class Tiles {
public:
  explicit Tiles(std::size_t particles)
      : m_tiles((particles + W - 1) / W) {}

  std::size_t tiles() const { return m_tiles; }
  std::size_t lanes() const { return m_tiles * W; }
  AlignedVector<T> make(int components) const {
    return AlignedVector<T>(lanes() * static_cast<std::size_t>(components));
  }
  static T& at(AlignedVector<T>& channel, int components, std::size_t particle, int component) {
    const auto n = static_cast<std::size_t>(components), c = static_cast<std::size_t>(component);
    return channel[((particle / W) * n + c) * W + particle % W];
  }

private:
  static constexpr std::size_t W = TILE_WIDTH<T>;
  std::size_t m_tiles;
};

} // namespace

template <class T>
ConstitutiveReport run_kernel(const Material& material, Isa isa, double dt, std::vector<Sample>& samples) {
  const auto compiled = compile_material(material);
  EXPECT_TRUE(compiled) << (compiled ? "" : compiled.error().message);
  if (!compiled)
    return {};
  const MaterialConstants<T> constants = constants_in<T>(compiled->constants);
  const MaterialKernels<T> kernels = find_material_kernels<T>(material, *compiled, isa);
  const Tiles<T> shape(samples.size());
  auto L = shape.make(9), F = shape.make(9), tau = shape.make(6), energy = shape.make(1);
  std::vector<AlignedVector<T>> state(CHANNEL_COUNT);
  ConstitutiveTiles<T> tiles;
  tiles.count = static_cast<int>(shape.tiles());
  tiles.dt = static_cast<T>(dt);
  for (const Channel channel : compiled->channels) {
    auto& values = state[static_cast<std::size_t>(channel)];
    values = shape.make(channel_info(channel).components);
    tiles.state[static_cast<int>(channel)] = values.data();
  }
  const auto scalar = [&](Channel channel, std::size_t p) -> T* {
    auto& values = state[static_cast<std::size_t>(channel)];
    return values.empty() ? nullptr : &Tiles<T>::at(values, 1, p, 0);
  };
  for (std::size_t p = 0; p < shape.lanes(); ++p) {
    const Sample& s = samples[std::min(p, samples.size() - 1)];
    for (int i = 0; i < 9; ++i) {
      Tiles<T>::at(L, 9, p, i) = static_cast<T>(s.L(i / 3, i % 3));
      Tiles<T>::at(F, 9, p, i) = static_cast<T>(s.F(i / 3, i % 3));
    }
    const auto put = [&](Channel channel, double value) {
      if (T* to = scalar(channel, p))
        *to = static_cast<T>(value);
    };
    put(Channel::hardening, s.history.flow);
    put(Channel::plastic_volume, s.history.volume_ratio);
    put(Channel::volume_correction, s.history.volume_correction);
    put(Channel::stiffness_scale, s.stiffness);
    put(Channel::strength_scale, s.strength);
    auto& frame = state[static_cast<std::size_t>(Channel::frame)];
    for (int i = 0; i < 4 && !frame.empty(); ++i)
      Tiles<T>::at(frame, 4, p, i) = static_cast<T>(s.frame[i]);
    auto& moment = state[static_cast<std::size_t>(Channel::second_moment)];
    for (int i = 0; i < 6 && !moment.empty(); ++i)
      Tiles<T>::at(moment, 6, p, i) = static_cast<T>(s.second_moment(ORDER[i][0], ORDER[i][1]));
  }
  tiles.velocity_gradient = L.data();
  tiles.affine = L.data();
  tiles.deformation = F.data();
  tiles.stress = tau.data();
  const ConstitutiveReport report = kernels.update(constants, tiles);
  kernels.energy(constants, tiles, energy.data());
  for (std::size_t p = 0; p < samples.size(); ++p) {
    Sample& s = samples[p];
    for (int i = 0; i < 9; ++i)
      s.F(i / 3, i % 3) = Tiles<T>::at(F, 9, p, i);
    for (int i = 0; i < 6; ++i)
      s.tau(ORDER[i][0], ORDER[i][1]) = s.tau(ORDER[i][1], ORDER[i][0]) = Tiles<T>::at(tau, 6, p, i);
    s.energy = energy[p];
    const auto take = [&](Channel channel, double& value) {
      if (const T* from = scalar(channel, p))
        value = *from;
    };
    take(Channel::hardening, s.history.flow);
    take(Channel::plastic_volume, s.history.volume_ratio);
    take(Channel::volume_correction, s.history.volume_correction);
    auto& frame = state[static_cast<std::size_t>(Channel::frame)];
    for (int i = 0; i < 4 && !frame.empty(); ++i)
      s.frame[i] = Tiles<T>::at(frame, 4, p, i);
    auto& moment = state[static_cast<std::size_t>(Channel::second_moment)];
    for (int i = 0; i < 6 && !moment.empty(); ++i)
      s.second_moment(ORDER[i][0], ORDER[i][1]) = s.second_moment(ORDER[i][1], ORDER[i][0]) =
          Tiles<T>::at(moment, 6, p, i);
  }
  return report;
}

template ConstitutiveReport run_kernel<float>(const Material&, Isa, double, std::vector<Sample>&);
template ConstitutiveReport run_kernel<double>(const Material&, Isa, double, std::vector<Sample>&);

} // namespace wry::mpm::test
