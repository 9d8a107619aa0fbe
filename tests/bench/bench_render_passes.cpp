// What a 1080p picture costs, pass by pass, and a PNG of it. Run with: bench_render_passes [out.csv]
// Columns: case, samples, pass, processor milliseconds and wall milliseconds a picture (median of the runs).

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>

#include <unistd.h>

#include "render/mesh_scene.h"
#include "render/png.h"
#include "render/renderer.h"

namespace {

using namespace wry;
using namespace wry::render;

constexpr int RUNS = 5;

/// A lumpy ball of 2 * rings * segments triangles, about.
geometry::SurfaceMesh lumpy_ball(int rings, int segments) {
  geometry::SurfaceMesh mesh;
  mesh.vertices.resize((rings + 1) * segments, 3);
  mesh.triangles.resize(2 * rings * segments, 3);
  constexpr double PI = std::numbers::pi;
  for (int r = 0; r <= rings; ++r) {
    for (int s = 0; s < segments; ++s) {
      const double polar = PI * r / rings;
      const double azimuth = 2 * PI * s / segments;
      const Vec3 d(std::sin(polar) * std::sin(azimuth), std::cos(polar), std::sin(polar) * std::cos(azimuth));
      mesh.vertices.row(r * segments + s) = ((0.5 + 0.04 * std::sin(9 * d.x()) * std::cos(8 * d.z())) * d).transpose();
    }
  }
  for (int r = 0; r < rings; ++r) {
    for (int s = 0; s < segments; ++s) {
      const int a = r * segments + s;
      const int b = r * segments + (s + 1) % segments;
      mesh.triangles.row(2 * (r * segments + s)) << a, a + segments, b;
      mesh.triangles.row(2 * (r * segments + s) + 1) << b, a + segments, b + segments;
    }
  }
  return mesh;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

double cpu_ms() {
  return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

double wall_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void print(std::FILE* out, const char* what, int samples, const char* pass, double cpu, double wall) {
  std::fprintf(out, "%s,%d,%s,%.1f,%.1f\n", what, samples, pass, cpu, wall);
  std::fflush(out);
}

int run(std::FILE* out, const char* what, const MeshScene& scene, int samples, const char* view) {
  RenderPlan plan;
  plan.looks = built_in_looks();
  plan.bounds = scene.bounds;
  plan.samples = samples;
  Result<Renderer> renderer = Renderer::create(plan, scene.scene);
  if (!renderer.ok()) {
    std::fprintf(stderr, "%s\n", renderer.error().message.c_str());
    return static_cast<int>(renderer.error().code);
  }
  Picture picture;
  picture.view = view;
  std::vector<std::vector<PassTime>> runs;
  std::vector<double> cpu_totals;
  std::vector<double> wall_totals;
  Image image;
  for (int i = 0; i <= RUNS; ++i) {
    const double cpu = cpu_ms();
    const double wall = wall_ms();
    Result<Image> drawn = renderer->draw(scene.frame, picture);
    if (!drawn.ok()) {
      std::fprintf(stderr, "%s\n", drawn.error().message.c_str());
      return static_cast<int>(drawn.error().code);
    }
    if (i == 0)
      continue; // the first compiles the shaders
    cpu_totals.push_back(cpu_ms() - cpu);
    wall_totals.push_back(wall_ms() - wall);
    runs.push_back(renderer->pass_times());
    image = std::move(*drawn);
  }
  for (std::size_t p = 0; p < runs[0].size(); ++p) {
    std::vector<double> cpu;
    std::vector<double> wall;
    for (const std::vector<PassTime>& times : runs) {
      cpu.push_back(times[p].cpu_ms);
      wall.push_back(times[p].wall_ms);
    }
    print(out, what, samples, runs[0][p].name.c_str(), median(cpu), median(wall));
  }
  print(out, what, samples, "picture", median(cpu_totals), median(wall_totals));
  std::vector<double> cpu_png;
  std::vector<double> wall_png;
  for (int i = 0; i < RUNS; ++i) {
    const double cpu = cpu_ms();
    const double wall = wall_ms();
    if (!encode_png(image, {{"shot", "benchmark"}}).ok())
      return 74;
    cpu_png.push_back(cpu_ms() - cpu);
    wall_png.push_back(wall_ms() - wall);
  }
  print(out, what, samples, "png", median(cpu_png), median(wall_png));
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  std::FILE* out = argc > 1 ? std::fopen(argv[1], "w") : stdout;
  if (out == nullptr) {
    std::fprintf(stderr, "%s: cannot be written\n", argv[1]);
    return 73;
  }
  char host[256] = "unknown";
  ::gethostname(host, sizeof(host) - 1);
  std::fprintf(out, "# machine %s, 1920x1080\ncase,samples,pass,cpu_ms,wall_ms\n", host);
  const MeshScene small = make_mesh_scene(lumpy_ball(224, 224), "ball", "rubber");
  const MeshScene large = make_mesh_scene(lumpy_ball(708, 708), "ball", "rubber");
  int code = 0;
  for (const int samples : {1, 4, 16})
    code = std::max(code, run(out, "100k triangles beauty", small, samples, "beauty"));
  code = std::max(code, run(out, "100k triangles wire", small, 4, "wire"));
  code = std::max(code, run(out, "1M triangles beauty", large, 4, "beauty"));
  if (out != stdout && std::fclose(out) != 0)
    return 74;
  return code;
}
