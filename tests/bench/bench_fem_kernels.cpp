// Microseconds per element of every energy, derivative and instruction set, from memory (100,000 elements: about 100 MB
// with their rotations, more than a core's share of the cache). Thread CPU time, one thread.

#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "sim/base/isa.h"
#include "sim/fem/element_kernels.h"
#include "sim/fem/kernels/kernel_table.h"

namespace {

using namespace wry;
using namespace wry::fem;

/// A box of 26 x 26 x 25 cells of six tets, slightly deformed, with random small rotations.
struct Scene {
  ElementGroup group;
  std::vector<double> positions, increments, rotations;
  NodeFields fields() const { return {positions.data(), increments.data(), rotations.data()}; }
};

geometry::TetMesh box_of_tets(int nx, int ny, int nz) {
  geometry::TetMesh mesh;
  const auto node = [&](int i, int j, int k) { return (k * (ny + 1) + j) * (nx + 1) + i; };
  mesh.vertices.resize((nx + 1) * (ny + 1) * (nz + 1), 3);
  for (int k = 0; k <= nz; ++k) {
    for (int j = 0; j <= ny; ++j) {
      for (int i = 0; i <= nx; ++i)
        mesh.vertices.row(node(i, j, k)) << 0.01 * i, 0.01 * j, 0.01 * k;
    }
  }
  constexpr int ORDERS[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}};
  mesh.tets.resize(6 * nx * ny * nz, 4);
  Eigen::Index row = 0;
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        for (int order = 0; order < 6; ++order, ++row) {
          int corner[3] = {i, j, k};
          mesh.tets(row, 0) = node(i, j, k);
          for (int step = 0; step < 3; ++step) {
            ++corner[ORDERS[order][step]];
            mesh.tets(row, step + 1) = node(corner[0], corner[1], corner[2]);
          }
          if (order >= 3)
            std::swap(mesh.tets(row, 1), mesh.tets(row, 2));
        }
      }
    }
  }
  return mesh;
}

/// Moves nodes a little and turns nodes and points by small random angles, so that no operand is special.
Scene make_scene(const FemMaterial& material) {
  const geometry::TetMesh mesh = box_of_tets(26, 26, 25);
  Scene scene;
  scene.group = *build_element_group(mesh, material, 0);
  std::mt19937 random(7);
  const auto noise = [&](double size) { return size * (static_cast<double>(random()) / 2147483648.0 - 1.0); };
  const auto rotation = [&](std::size_t stride, double* to) {
    double q[4] = {1.0, noise(0.1), noise(0.1), noise(0.1)};
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (std::size_t i = 0; i < 4; ++i)
      to[i * stride] = q[i] / norm;
  };
  const auto nodes = static_cast<std::size_t>(mesh.vertices.rows());
  for (std::size_t i = 0; i < 3 * nodes; ++i) {
    scene.positions.push_back(mesh.vertices.data()[i] + noise(0.0005));
    scene.increments.push_back(noise(0.1));
  }
  scene.rotations.resize(4 * nodes);
  for (std::size_t i = 0; i < nodes; ++i)
    rotation(1, &scene.rotations[4 * i]);
  for (std::size_t batch = 0; batch < scene.group.point_rotations.size() / (16 * LANES); ++batch) {
    for (std::size_t point = 0; point < POINTS; ++point) {
      for (std::size_t lane = 0; lane < LANES; ++lane)
        rotation(LANES, &scene.group.point_rotations[(batch * 16 + 4 * point) * LANES + lane]);
    }
  }
  return scene;
}

struct Variant {
  std::string name;
  FemMaterial material;
};

std::vector<Variant> variants() {
  std::vector<Variant> all;
  const auto add = [&](const std::string& name, ElasticModel model, auto&& change) {
    FemMaterial material;
    material.model = model;
    material.length_scale = 0.01;
    material.curvature_stiffness = Mat3::Constant(1.0);
    change(material);
    all.push_back({name, material});
  };
  const auto as_is = [](FemMaterial&) {};
  add("neo_hookean", ElasticModel::neo_hookean, as_is);
  add("neo_hookean_eq16", ElasticModel::neo_hookean_eq16, as_is);
  add("stvk", ElasticModel::stvk, as_is);
  add("corotated", ElasticModel::corotated, as_is);
  add("micropolar", ElasticModel::micropolar, as_is);
  add("micropolar_any_mu_c", ElasticModel::micropolar, [](FemMaterial& m) { m.couple_modulus_ratio = 2.0; });
  add("micropolar_det", ElasticModel::micropolar_det, as_is);
  add("micropolar_neo_hookean", ElasticModel::micropolar_neo_hookean, as_is);
  add("micropolar_orthotropic", ElasticModel::micropolar,
      [](FemMaterial& m) { m.curvature = CurvatureModel::orthotropic; });
  add("micropolar_orthotropic_basis", ElasticModel::micropolar, [](FemMaterial& m) {
    m.curvature = CurvatureModel::orthotropic;
    m.curvature_basis << 0.8, -0.6, 0.0, 0.6, 0.8, 0.0, 0.0, 0.0, 1.0;
  });
  add("micropolar_isotropic", ElasticModel::micropolar,
      [](FemMaterial& m) { m.curvature = CurvatureModel::isotropic; });
  return all;
}

/// Runs body(batch) over all batches per iteration and reports microseconds per element.
template <class Body> void run(benchmark::State& state, const Scene& scene, const Body& body) {
  for (auto _ : state) {
    for (int batch = 0; batch < scene.group.batch_count; ++batch)
      body(batch);
  }
  const double elements = static_cast<double>(state.iterations()) * scene.group.element_count;
  state.counters["us_per_element"] =
      benchmark::Counter(1e-6 * elements, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void register_variant(const Variant& variant, Isa isa) {
  const auto scene = std::make_shared<std::unique_ptr<Scene>>();
  const auto ready = [scene, variant]() -> Scene& {
    if (!*scene)
      *scene = std::make_unique<Scene>(make_scene(variant.material));
    return **scene;
  };
  const std::string name = variant.name + "/" + std::string(isa_name(isa)) + "/";
  const auto add = [&](const char* what, auto&& body) {
    benchmark::RegisterBenchmark((name + what).c_str(), body)->Unit(benchmark::kMillisecond)->MinTime(0.2);
  };
  add("energy", [ready, isa](benchmark::State& state) {
    const Scene& s = ready();
    const ElementKernel kernel = select_kernel(s.group, isa);
    alignas(64) double energy[LANES];
    run(state, s, [&](int batch) {
      kernel.energy(s.group, s.fields(), batch, energy);
      benchmark::DoNotOptimize(energy[0]);
    });
  });
  add("gradient", [ready, isa](benchmark::State& state) {
    const Scene& s = ready();
    const ElementKernel kernel = select_kernel(s.group, isa);
    const auto out = std::make_unique<BatchDerivatives>();
    run(state, s, [&](int batch) { kernel.gradient(s.group, s.fields(), batch, *out); });
  });
  add("hessian", [ready, scene, isa](benchmark::State& state) {
    const Scene& s = ready();
    const ElementKernel kernel = select_kernel(s.group, isa);
    const auto out = std::make_unique<BatchDerivatives>();
    run(state, s, [&](int batch) { kernel.hessian(s.group, s.fields(), batch, *out); });
    scene->reset(); // the last of a variant
  });
}

} // namespace

int main(int argc, char** argv) {
  for (const Variant& variant : variants()) {
    for (const Isa isa : {Isa::sse4, Isa::avx2, Isa::avx512}) {
      if (isa <= native_isa())
        register_variant(variant, isa);
    }
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv))
    return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
