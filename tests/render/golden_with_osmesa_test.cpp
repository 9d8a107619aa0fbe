#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>
#include <unistd.h>

#include "render/environment.h"
#include "render/png.h"
#include "tests/render/pictures_support.h"
#include "tests/render/shapes_support.h"

namespace wry::render {
namespace {

constexpr const char* GL_KEY = "gl";
constexpr const char* CHILD_FILE = "WRY_RENDER_BITS_FILE";

/// A torus, a ball above it and a box: creases, holes, soft and hard shadows, contact, two looks, one heat channel.
MeshScene still_life() {
  MeshScene scene = make_mesh_scene(testing::torus(Vec3(0, .35, 0), .8, .35, 48, 32), "torus", "rubber");
  const auto add = [&](const geometry::SurfaceMesh& mesh, const char* name, const char* look) {
    const MeshScene more = make_mesh_scene(mesh, name, look);
    scene.scene.bodies.push_back(more.scene.bodies[0]);
    scene.frame.bodies.push_back(more.frame.bodies[0]);
    scene.bounds.include(more.bounds);
  };
  add(testing::sphere(Vec3(0, 1.2, 0), .35, 24, 48), "ball", "metal");
  add(testing::box(Vec3(-1.8, 0, -.9), Vec3(-1.3, 1.2, -.4)), "box", "card");
  Channel height{"height", ChannelOn::vertex, 1, ChannelStorage::float32, {}};
  for (Eigen::Index i = 0; i < scene.scene.bodies[0].rest_positions.rows(); ++i)
    height.values.push_back(scene.scene.bodies[0].rest_positions(i, 1));
  scene.frame.bodies[0].channels.push_back(height);
  return scene;
}

RenderPlan still_life_plan(const MeshScene& scene) {
  RenderPlan plan = testing::small_plan(scene);
  plan.slate = {"still life"};
  plan.views.push_back(heat_view({.channel = "height", .low = 0, .high = 0.7, .title = "", .unit = "m"}));
  return plan;
}

struct Difference {
  double mean = 0.0;
  double far_off = 0.0; ///< share of the values that differ by more than 12
};

Difference difference(const Image& a, const Image& b) {
  Difference found;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const int apart = std::abs(static_cast<int>(a.pixels[i]) - static_cast<int>(b.pixels[i]));
    found.mean += apart / static_cast<double>(a.pixels.size());
    found.far_off += apart > 12 ? 1.0 / static_cast<double>(a.pixels.size()) : 0.0;
  }
  return found;
}

/// Exact on the Mesa that drew the golden picture, close on any other. WRY_UPDATE_GOLDEN=1 writes the pictures anew.
class Golden : public ::testing::TestWithParam<const char*> {};

void expect_golden(const std::string& name, const MeshScene& scene, const RenderPlan& plan, const std::string& view) {
  Result<Renderer> renderer = Renderer::create(plan, scene.scene);
  ASSERT_TRUE(renderer.ok()) << renderer.error().message;
  Picture picture;
  picture.view = view;
  const Result<Image> image = renderer->draw(scene.frame, picture);
  ASSERT_TRUE(image.ok()) << image.error().message;
  const GlVersion& version = renderer->gl_version();
  const std::string drawn_by = version.version + ", " + version.renderer;
  const std::filesystem::path path = std::filesystem::path(WRY_TEST_DATA) / "golden" / ("render_" + name + ".png");
  if (std::getenv("WRY_UPDATE_GOLDEN") != nullptr) {
    PngSettings small;
    small.compression = 12;
    ASSERT_TRUE(write_png(path, *image, {{GL_KEY, drawn_by}}, small).ok());
  }
  const Result<PngContents> golden = read_png(path);
  ASSERT_TRUE(golden.ok()) << golden.error().message;
  ASSERT_EQ(golden->image.width, image->width);
  ASSERT_EQ(golden->image.height, image->height);
  Image opaque = *image;
  for (std::size_t i = 3; i < opaque.pixels.size(); i += 4)
    opaque.pixels[i] = 255;
  const Difference apart = difference(opaque, golden->image);
  ASSERT_EQ(golden->texts.size(), 1U);
  if (golden->texts[0].value == drawn_by) {
    EXPECT_EQ(apart.mean, 0.0);
  } else {
    EXPECT_LT(apart.mean, 1.0);
    EXPECT_LT(apart.far_off, 0.005);
  }
}

TEST_P(Golden, StillLifeLooksAsItDid) {
  const MeshScene scene = still_life();
  expect_golden(GetParam(), scene, still_life_plan(scene), GetParam());
}

TEST(GoldenScene, StrawsByDay) {
  const MeshScene scene = testing::heap(300, {GrainShape::straw, Vec3(1, 1, 7)}, "straw");
  RenderPlan plan = testing::small_plan(scene);
  plan.rig = day_rig();
  expect_golden("straws-by-day", scene, plan, "beauty");
}

TEST(GoldenScene, DirectorsOnClay) {
  MeshScene scene = make_mesh_scene(testing::torus(Vec3(0, .35, 0), .8, .35, 24, 12), "torus", "rubber");
  Channel rotation{"microrotation", ChannelOn::vertex, 4, ChannelStorage::float32, {}};
  for (Eigen::Index i = 0; i < scene.scene.bodies[0].rest_positions.rows(); ++i) {
    const double half = 0.4 * scene.scene.bodies[0].rest_positions(i, 0);
    rotation.values.insert(rotation.values.end(), {std::cos(half), 0.0, std::sin(half), 0.0});
  }
  scene.frame.bodies[0].channels.push_back(rotation);
  expect_golden("directors", scene, testing::small_plan(scene), "directors");
}

TEST(GoldenScene, ShadowCaughtInAlpha) {
  MeshScene scene = still_life();
  RenderPlan plan = still_life_plan(scene);
  plan.ground.kind = Ground::Kind::catch_shadow;
  plan.background = Background::clear;
  expect_golden("caught-shadow", scene, plan, "beauty");
}

TEST(GoldenScene, LensAndShutter) {
  MeshScene scene = still_life();
  for (std::size_t b = 0; b < scene.scene.bodies.size(); ++b) {
    const auto rows = static_cast<std::size_t>(scene.scene.bodies[b].rest_positions.rows());
    Channel velocity{"velocity", ChannelOn::vertex, 3, ChannelStorage::float32, std::vector<double>(3 * rows, 0.0)};
    for (std::size_t i = 0; b == 1 && i < rows; ++i)
      velocity.values[3 * i + 1] = -12.0;
    scene.frame.bodies[b].channels.push_back(velocity);
  }
  RenderPlan plan = still_life_plan(scene);
  plan.samples = 16;
  plan.shutter = 0.5;
  plan.camera.f_stop = 0.15;
  expect_golden("lens-and-shutter", scene, plan, "beauty");
}

INSTANTIATE_TEST_SUITE_P(Views, Golden, ::testing::Values("beauty", "clay", "wire", "heat-height"),
                         [](const auto& which) {
                           std::string name = which.param;
                           std::erase(name, '-');
                           return name;
                         });

/// Mesa reads its settings once a process, so each way to draw gets its own: this program again, with one test.
std::vector<char> pixels_of_child(const std::string& backend, int threads) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / fmt::format("wry_bits_{}_{}_{}", ::getpid(), backend, threads);
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  const std::string command = fmt::format("{}='{}' WRY_RENDER_BITS_BACKEND={} WRY_RENDER_BITS_THREADS={} '{}' "
                                          "--gtest_filter=RenderBits.Child >/dev/null",
                                          CHILD_FILE, file.string(), backend, threads, program);
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  std::ifstream in(file, std::ios::binary);
  std::vector<char> pixels{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  std::filesystem::remove(file);
  return pixels;
}

TEST(RenderBits, Child) {
  const char* file = std::getenv(CHILD_FILE);
  if (file == nullptr)
    GTEST_SKIP() << "draws for the test below";
  const MeshScene scene = still_life();
  RenderPlan plan = still_life_plan(scene);
  plan.backend = *parse_gl_backend(std::getenv("WRY_RENDER_BITS_BACKEND"));
  plan.raster_threads = std::atoi(std::getenv("WRY_RENDER_BITS_THREADS"));
  Result<Renderer> renderer = Renderer::create(plan, scene.scene);
  ASSERT_TRUE(renderer.ok()) << renderer.error().message;
  const Result<Image> image = renderer->draw(scene.frame, {});
  ASSERT_TRUE(image.ok());
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(image->pixels.data()), static_cast<std::streamsize>(image->pixels.size()));
}

TEST(RenderBits, AreTheSameForAnyThreadsAndForOsmesaAndEgl) {
  const std::vector<char> first = pixels_of_child("osmesa", 0);
  ASSERT_EQ(first.size(), 192U * 108U * 4U);
  for (const int threads : {1, 2, 8})
    EXPECT_TRUE(pixels_of_child("osmesa", threads) == first) << threads << " threads";
  EXPECT_TRUE(pixels_of_child("egl", 0) == first) << "EGL";
}

} // namespace
} // namespace wry::render
