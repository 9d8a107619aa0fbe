// What a 1080p picture costs, pass by pass, and a PNG of it; then how the error falls as sub-frames grow.
// Run with: bench_render_passes [out.csv [part of a case's name [sub-frames]]]
// Columns: case, samples, pass, processor milliseconds and wall milliseconds a picture (median of the runs). The pass
// "picture" is the sum with read-back and text, "frames/min on 2 cores" what two processes draw and write in a minute
// of processor time, "memory MB" the most that the process has held so far, "rmse" the error against 256 sub-frames.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <numbers>
#include <random>
#include <string>

#include <sys/resource.h>
#include <unistd.h>

#include "render/environment.h"
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

/// A cone of rods in random directions, half full.
MeshScene heap_of_rods(int count) {
  MeshScene made;
  SceneBody body;
  body.name = "heap";
  body.kind = BodyKind::particles;
  body.look = "straw";
  constexpr double HEIGHT = 0.45;
  body.grain = {GrainShape::rod, Vec3(1, 1, 10)};
  body.grain.size *= std::cbrt(0.5 * std::numbers::pi * 0.25 * HEIGHT / 3.0 / count / body.grain.size.prod());
  Channel position{"position", ChannelOn::particle, 3, ChannelStorage::float32, {}};
  Channel orientation{"orientation", ChannelOn::particle, 4, ChannelStorage::float32, {}};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::normal_distribution<double> normal;
  while (position.values.size() < 3 * static_cast<std::size_t>(count)) {
    const Vec3 p(0.5 * unit(random), 0.5 * HEIGHT * (1.0 + unit(random)), 0.5 * unit(random));
    if (std::hypot(p.x(), p.z()) > 0.5 * (1.0 - p.y() / HEIGHT))
      continue;
    position.values.insert(position.values.end(), {p.x(), p.y(), p.z()});
    for (int i = 0; i < 4; ++i)
      orientation.values.push_back(normal(random));
  }
  made.scene.bodies.push_back(std::move(body));
  FrameBody on_frame;
  on_frame.name = "heap";
  on_frame.channels = {std::move(position), std::move(orientation)};
  made.frame.number = 1;
  made.frame.bodies.push_back(std::move(on_frame));
  if (!made.bounds.include(made.scene, made.frame).ok())
    std::abort();
  return made;
}

/// Gives every vertex of a mesh scene a velocity, so that its pictures can blur.
MeshScene moving(MeshScene scene) {
  const auto rows = static_cast<std::size_t>(scene.scene.bodies[0].rest_positions.rows());
  scene.frame.bodies[0].channels.push_back(
      {"velocity", ChannelOn::vertex, 3, ChannelStorage::float32, std::vector<double>(3 * rows, 1.0)});
  return scene;
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

RenderPlan plan_of(const MeshScene& scene, int samples) {
  RenderPlan plan;
  plan.looks = built_in_looks();
  plan.bounds = scene.bounds;
  plan.samples = samples;
  return plan;
}

double most_memory_mb() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

int run(std::FILE* out, const char* what, const MeshScene& scene, const RenderPlan& plan, const char* view,
        int runs_wanted) {
  const int samples = plan.samples;
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
  for (int i = 0; i <= runs_wanted; ++i) {
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
  const double per_minute = 2.0 * 60e3 / (median(cpu_totals) + median(cpu_png));
  print(out, what, samples, "frames/min on 2 cores", per_minute, per_minute);
  print(out, what, samples, "memory MB", most_memory_mb(), most_memory_mb());
  return 0;
}

/// The error of few sub-frames against 256, on edges, penumbra, lens and motion at once.
int converge(std::FILE* out, const MeshScene& scene) {
  std::vector<float> truth;
  for (const int samples : {256, 1, 2, 4, 8, 16, 32, 64}) {
    RenderPlan plan = plan_of(scene, samples);
    plan.size = {960, 540};
    plan.shutter = 0.5;
    plan.camera.f_stop = 0.4;
    Result<Renderer> renderer = Renderer::create(plan, scene.scene);
    if (!renderer.ok())
      return static_cast<int>(renderer.error().code);
    if (!renderer->draw_linear(scene.frame, {}).ok())
      return 74; // compiles the shaders
    const double cpu = cpu_ms();
    const double wall = wall_ms();
    Result<LinearImage> image = renderer->draw_linear(scene.frame, {});
    if (!image.ok())
      return static_cast<int>(image.error().code);
    const double cpu_taken = cpu_ms() - cpu;
    print(out, "convergence 960x540", samples, "picture", cpu_taken, wall_ms() - wall);
    if (truth.empty()) {
      truth = image->pixels;
      continue;
    }
    double sum = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (i % 4 != 3)
        sum += std::pow(static_cast<double>(image->pixels[i]) - static_cast<double>(truth[i]), 2);
    }
    const double rmse = std::sqrt(sum / (0.75 * static_cast<double>(truth.size())));
    std::fprintf(out, "convergence 960x540,%d,rmse,%.6f,%.6f\n", samples, rmse, rmse);
  }
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  const bool asks = std::any_of(argv + 1, argv + argc, [](const char* argument) { return argument[0] == '-'; });
  if (asks || argc > 4) {
    const std::string first = argc > 1 ? argv[1] : "";
    const bool help = argc == 2 && (first == "--help" || first == "-h");
    std::fprintf(help ? stdout : stderr,
                 "usage: bench_render_passes [OUT.csv [CASE [SUB-FRAMES]]]\n"
                 "Writes what each pass of a 1080p picture costs to OUT.csv, or to the standard output without it.\n"
                 "CASE: only cases whose name has this in it. SUB-FRAMES: only pictures of so many.\n");
    return help ? 0 : 2;
  }
  std::FILE* out = argc > 1 ? std::fopen(argv[1], "w") : stdout;
  if (out == nullptr) {
    std::fprintf(stderr, "%s: cannot be written\n", argv[1]);
    return 73;
  }
  char host[256] = "unknown";
  ::gethostname(host, sizeof(host) - 1);
  std::fprintf(out, "# machine %s, 1920x1080\ncase,samples,pass,cpu_ms,wall_ms\n", host);
  const std::string only = argc > 2 ? argv[2] : "";
  const int only_samples = argc > 3 ? std::atoi(argv[3]) : 0;
  const auto wanted = [&](const std::string& what) { return what.find(only) != std::string::npos; };
  int code = 0;
  const auto draw = [&](const char* what, const MeshScene& scene, const RenderPlan& plan, const char* view, int runs) {
    if (wanted(what) && (only_samples == 0 || only_samples == plan.samples))
      code = std::max(code, run(out, what, scene, plan, view, runs));
  };
  {
    const MeshScene ball = make_mesh_scene(lumpy_ball(224, 224), "ball", "rubber");
    for (const int samples : {1, 4, 16})
      draw("100k triangles beauty", ball, plan_of(ball, samples), "beauty", RUNS);
    draw("100k triangles clay", ball, plan_of(ball, 4), "clay", RUNS);
    draw("100k triangles wire", ball, plan_of(ball, 4), "wire", RUNS);
    RenderPlan bare = plan_of(ball, 4);
    bare.rig.occlusion = Rig::Occlusion::none;
    bare.rig.lights[0].shadow = Light::Shadow::none;
    draw("100k triangles no shadow no occlusion", ball, bare, "beauty", RUNS);
    RenderPlan day = plan_of(ball, 4);
    day.rig = day_rig();
    draw("100k triangles day", ball, day, "beauty", RUNS);
    RenderPlan glass = plan_of(ball, 4);
    glass.looks["rubber"] = glass.looks["glass"];
    draw("100k triangles glass", ball, glass, "beauty", RUNS);
    const MeshScene flying = moving(ball);
    RenderPlan blurred = plan_of(flying, 16);
    blurred.shutter = 0.5;
    blurred.camera.f_stop = 0.4;
    draw("100k triangles lens and shutter", flying, blurred, "beauty", 2);
    if (wanted("convergence"))
      code = std::max(code, converge(out, moving(make_mesh_scene(lumpy_ball(96, 96), "ball", "rubber"))));
  }
  if (wanted("200k rods beauty")) {
    const MeshScene rods = heap_of_rods(200'000);
    for (const int samples : {1, 4, 16})
      draw("200k rods beauty", rods, plan_of(rods, samples), "beauty", samples == 16 ? 1 : 3);
  }
  if (wanted("1M triangles beauty")) {
    const MeshScene large = make_mesh_scene(lumpy_ball(708, 708), "ball", "rubber");
    draw("1M triangles beauty", large, plan_of(large, 4), "beauty", 2);
  }
  if (wanted("2M rods beauty")) {
    const MeshScene many = heap_of_rods(2'000'000);
    draw("2M rods beauty", many, plan_of(many, 1), "beauty", 1);
  }
  if (out != stdout && std::fclose(out) != 0)
    return 74;
  return code;
}
