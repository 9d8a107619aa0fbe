// How long meshing takes: ./bench_geometry_meshing. Counters give the size and the quality of what was made.

#include <benchmark/benchmark.h>

#include "sim/geometry/isosurface_stuffing.h"
#include "sim/geometry/primitives.h"
#include "sim/geometry/remesh.h"
#include "sim/geometry/shell_extrusion.h"
#include "sim/geometry/signed_distance.h"

namespace {

using namespace wry;
using namespace wry::geometry;

/// A bean-like closed surface of about 30,000 triangles and one metre, so that no file is needed.
SurfaceMesh bean() {
  SurfaceMesh mesh = *make_sphere(0.35, 0.011);
  for (Eigen::Index i = 0; i < mesh.vertices.rows(); ++i) {
    const double y = mesh.vertices(i, 1);
    mesh.vertices(i, 0) += 0.6 * y * y;
    mesh.vertices(i, 1) *= 1.4;
    mesh.vertices(i, 2) *= 0.8 + 0.5 * y;
  }
  return mesh;
}

double edge_of(const benchmark::State& state) {
  return static_cast<double>(state.range(0)) / 1000.0;
}

void report(benchmark::State& state, const TetQuality& quality) {
  state.counters["tets"] = static_cast<double>(quality.tets);
  state.counters["min_dihedral"] = quality.min_dihedral;
  state.counters["max_dihedral"] = quality.max_dihedral;
}

void remesh_surface(benchmark::State& state) {
  const SurfaceMesh surface = bean();
  for (auto _ : state)
    benchmark::DoNotOptimize(remesh(surface, edge_of(state)));
}

void hollow_shell(benchmark::State& state) {
  const SurfaceMesh surface = bean();
  ShellSettings settings;
  settings.thickness = 0.02;
  settings.edge = edge_of(state);
  for (auto _ : state) {
    const Result<ShellMesh> shell = extrude_shell(surface, settings);
    if (!shell)
      return state.SkipWithError(shell.error().message.c_str());
    report(state, shell->quality);
  }
}

void fill_solid(benchmark::State& state) {
  const SurfaceMesh surface = bean();
  StuffingSettings settings;
  settings.edge = edge_of(state);
  for (auto _ : state) {
    const Result<SolidMesh> solid = stuff_solid(surface, settings);
    if (!solid)
      return state.SkipWithError(solid.error().message.c_str());
    report(state, solid->quality);
  }
}

void sample_signed_distance(benchmark::State& state) {
  const SurfaceMesh surface = bean();
  for (auto _ : state) {
    const Result<SignedDistance> field = SignedDistance::from_surface(surface, edge_of(state));
    if (!field)
      return state.SkipWithError(field.error().message.c_str());
    state.counters["voxels"] = static_cast<double>(field->sampled_voxels());
  }
}

// Arguments: the target edge, or the voxel, in millimetres.
BENCHMARK(remesh_surface)->Arg(60)->Arg(45)->Arg(30)->Unit(benchmark::kMillisecond);
BENCHMARK(hollow_shell)->Arg(60)->Arg(45)->Arg(30)->Unit(benchmark::kMillisecond);
BENCHMARK(fill_solid)->Arg(60)->Arg(45)->Arg(30)->Unit(benchmark::kMillisecond);
BENCHMARK(sample_signed_distance)->Arg(20)->Arg(10)->Unit(benchmark::kMillisecond);

} // namespace

BENCHMARK_MAIN();
