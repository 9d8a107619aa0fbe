// Nanoseconds per particle of the constitutive update alone, by family, law, precision and instruction set: 16,384
// particles in runs of 4 tiles, their strains of the size that sand under its own weight has. Thread CPU time.

#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "sim/base/aligned.h"
#include "sim/mpm/material.h"

namespace {

using namespace wry;
using namespace wry::mpm;

constexpr std::size_t PARTICLES = 16384;
constexpr int RUN = 4; // tiles

Material straw(Plasticity plasticity) {
  Material material;
  material.youngs_modulus = {5e5, 5e5, 5e4};
  material.poisson_ratio = {0.4, 0.4, 0.1};
  material.plastic_scale = {0.8, 0.8, 1.4};
  material.plasticity = plasticity;
  return material;
}

Material sand(Plasticity plasticity, Elasticity elasticity) {
  Material material;
  material.plasticity = plasticity;
  material.elasticity = elasticity;
  return material;
}

Material turning() {
  Material material;
  material.plasticity = Plasticity::drucker_prager;
  material.reorientation.emplace();
  material.reorientation->parallel = {5e4, 0.1, 1.4};
  material.reorientation->perpendicular = {5e5, 0.13, 0.8};
  material.reorientation->isotropic = {2e5, 0.12, 1.0};
  return material;
}

template <class T> struct Cloud {
  AlignedVector<T> gradient, deformation, stress;
  std::vector<AlignedVector<T>> state;

  explicit Cloud(const CompiledMaterial& compiled, double strain)
      : gradient(9 * PARTICLES)
      , deformation(9 * PARTICLES)
      , stress(6 * PARTICLES)
      , state(CHANNEL_COUNT) {
    std::mt19937 random(7);
    const auto noise = [&] { return static_cast<double>(random()) / 2147483648.0 - 1.0; };
    constexpr std::size_t W = TILE_WIDTH<T>;
    for (std::size_t i = 0; i < 9 * PARTICLES; ++i) {
      const bool diagonal = (i / W) % 9 % 4 == 0;
      gradient[i] = static_cast<T>(noise());
      deformation[i] = static_cast<T>((diagonal ? 1.0 - 0.3 * strain : 0.0) + strain * noise());
    }
    for (const Channel channel : compiled.channels) {
      const std::size_t components = static_cast<std::size_t>(channel_info(channel).components);
      auto& values = state[static_cast<std::size_t>(channel)];
      values.resize(components * PARTICLES);
      for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t c = (i / W) % components;
        const bool one = (channel == Channel::frame && c == 0) || channel == Channel::plastic_volume;
        values[i] = static_cast<T>(one ? 1.0 : channel == Channel::second_moment && c < 3 ? 1.0 / 3.0 : 0.0);
      }
    }
  }
};

template <class T> void update(benchmark::State& state, const Material& material, Isa isa, double strain) {
  const Result<CompiledMaterial> compiled = compile_material(material);
  if (!compiled) {
    state.SkipWithError(compiled.error().message.c_str());
    return;
  }
  const MaterialConstants<T> constants = constants_in<T>(compiled->constants);
  const MaterialKernels<T> kernels = find_material_kernels<T>(material, *compiled, isa);
  const Cloud<T> start(*compiled, strain);
  Cloud<T> cloud = start;
  constexpr int TILES = static_cast<int>(PARTICLES) / TILE_WIDTH<T>;
  for (auto _ : state) {
    state.PauseTiming();
    cloud.deformation = start.deformation;
    state.ResumeTiming();
    for (int tile = 0; tile < TILES; tile += RUN) {
      const auto at = [tile](AlignedVector<T>& values, int components) {
        return values.empty() ? nullptr : values.data() + tile * components * TILE_WIDTH<T>;
      };
      ConstitutiveTiles<T> tiles;
      tiles.count = RUN;
      tiles.dt = static_cast<T>(1e-4);
      tiles.velocity_gradient = tiles.affine = at(cloud.gradient, 9);
      tiles.deformation = at(cloud.deformation, 9);
      tiles.stress = at(cloud.stress, 6);
      for (int c = 0; c < CHANNEL_COUNT; ++c)
        tiles.state[c] = at(cloud.state[static_cast<std::size_t>(c)], CHANNELS[c].components);
      benchmark::DoNotOptimize(kernels.update(constants, tiles));
    }
  }
  state.counters["ns/particle"] =
      benchmark::Counter(static_cast<double>(PARTICLES) * 1e-9,
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

struct Case {
  const char* name;
  Material material;
  double strain;
};

} // namespace

int main(int count, char** arguments) {
  benchmark::Initialize(&count, arguments);
  using P = Plasticity;
  const Case cases[] = {
      {"isotropic hencky drucker-prager", sand(P::drucker_prager, Elasticity::hencky), 0.005},
      {"isotropic hencky drucker-prager, strain .3: by eigenvectors", sand(P::drucker_prager, Elasticity::hencky), 0.3},
      {"isotropic fixed-corotated snow", sand(P::snow, Elasticity::fixed_corotated), 0.005},
      {"orthotropic hencky", straw(P::none), 0.005},
      {"orthotropic hencky drucker-prager", straw(P::drucker_prager), 0.005},
      {"orthotropic hencky drucker-prager, strain .3: by eigenvectors", straw(P::drucker_prager), 0.3},
      {"orthotropic hencky shear", straw(P::shear), 0.005},
      {"reoriented hencky drucker-prager", turning(), 0.005},
  };
  for (const Isa isa : {Isa::sse4, Isa::avx2, Isa::avx512}) {
    for (const Case& c : cases) {
      if (isa > native_isa())
        continue;
      const std::string name = std::string(isa_name(isa)) + " " + c.name;
      benchmark::RegisterBenchmark(("f32 " + name).c_str(),
                                   [=](benchmark::State& state) { update<float>(state, c.material, isa, c.strain); });
      benchmark::RegisterBenchmark(("f64 " + name).c_str(),
                                   [=](benchmark::State& state) { update<double>(state, c.material, isa, c.strain); });
    }
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
