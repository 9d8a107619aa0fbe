#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/cache/frame_cache.h"
#include "sim/base/rotation.h"
#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A wedge of .004 x .006 x .03 m, its length along z: what every grain is drawn as. Read by our own reader.
const std::string WEDGE = R"(ply
format ascii 1.0
element vertex 6
property float x
property float y
property float z
element face 8
property list uchar int vertex_indices
end_header
0 0 0
.004 0 0
0 .006 0
0 0 .03
.004 0 .03
0 .006 .03
3 0 2 1
3 3 4 5
3 0 1 4
3 0 4 3
3 1 2 5
3 1 5 4
3 2 0 3
3 2 3 5
)";

const std::string HEAP = R"([shot]
name = "heap"
frames = "1-4"
[[body]]
name = "heap"
region = { box = { min = [0, 0.05, 0], max = [0.1, 0.15, 0.1] } }
particles_per_cell = 1
material = "sand"
sub_particles = { per_particle = 2, mesh = "wedge.ply" }
[material.sand]
model = "mpm"
plasticity = "drucker-prager"
youngs_modulus = 5e4
poisson_ratio = 0.3
[mpm]
cell_size = 0.025
[[collider]]
name = "floor"
plane = { height = 0 }
[[measure]]
name = "inside"
kind = "grains_inside"
body = "heap"
)";

class GrainMesh : public testing::Test {
protected:
  void SetUp() override {
    write_text(m_folder.path() / "wedge.ply", WEDGE);
    write_text(m_folder.path() / "heap.toml", HEAP);
  }
  Outcome wry(const std::string& verb, std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {verb, "heap.toml", "--out", "o"};
    words.insert(words.end(), more.begin(), more.end());
    return run_wry(words, m_folder.path());
  }
  pipeline::FrameCache cache() const { return *pipeline::FrameCache::open_to_read(m_folder.path() / "o" / "frames"); }
  Frame frame(int number) const { return *cache().read_frame(number); }
  const TemporaryFolder m_folder;
};

const FrameBody& grains_of(const Frame& frame) {
  for (const FrameBody& body : frame.bodies) {
    if (body.name == "heap.grains")
      return body;
  }
  return frame.bodies.front();
}

TEST_F(GrainMesh, IsDrawnAtItsOwnSizeAndMeetsTheFloorByItsThinnestExtent) {
  ASSERT_EQ(wry("simulate").exit_code, 0);
  const SceneStatic scene = *cache().read_static();
  const SceneBody& body = scene.bodies.at(1);
  EXPECT_EQ(body.kind, BodyKind::particles);
  EXPECT_EQ(body.grain.shape, GrainShape::mesh);
  EXPECT_EQ(body.triangles.rows(), 8);
  EXPECT_TRUE(body.grain.size.isApprox(Vec3(0.004, 0.006, 0.03), 1e-6)) << body.grain.size.transpose();
  const Points low = body.rest_positions.colwise().minCoeff(), high = body.rest_positions.colwise().maxCoeff();
  EXPECT_TRUE(low.isApproxToConstant(-0.5, 1e-6) && high.isApproxToConstant(0.5, 1e-6));
  const Frame last = frame(4);
  const std::vector<double>& x = find_channel(grains_of(last), "position")->values;
  const std::vector<double>& size = find_channel(grains_of(last), "size")->values;
  ASSERT_EQ(x.size(), size.size());
  for (std::size_t i = 0; i < x.size(); i += 3)
    EXPECT_GE(x[i + 1], 0.0);
}

TEST_F(GrainMesh, IsStretchedToTheSizeAndTurnedToTheAxisThatTheShotAsksFor) {
  ASSERT_EQ(wry("simulate", {"--frames", "1", "--set", "body.heap.sub_particles.size=[0.01, 0.02, 0.03]", "--set",
                             "body.heap.sub_particles.mesh_along=x"})
                .exit_code,
            0);
  const SceneStatic scene = *cache().read_static();
  EXPECT_TRUE(scene.bodies.at(1).grain.size.isApprox(Vec3(0.01, 0.02, 0.03)));
  // The wedge's slanted face keeps clear of the corner (x high, y high); along x it is the corner (z, y) of the file.
  const Points& rest = scene.bodies.at(1).rest_positions;
  int ends = 0;
  for (Eigen::Index i = 0; i < rest.rows(); ++i)
    ends += rest(i, 2) > 0.49 ? 1 : 0;
  EXPECT_EQ(ends, 2) << "the file's x end has two vertices, its z end three\n" << rest;
}

TEST_F(GrainMesh, GoesToUsdAsTheInstancersPrototypeAndToObjAsCopiesInPlace) {
  ASSERT_EQ(wry("simulate", {"--frames", "1-2"}).exit_code, 0);
  const Outcome exported = wry("export", {"--frames", "1-2", "--to", "usda,obj"});
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  const fs::path exports = m_folder.path() / "o" / "exports";
  const std::string usd = read_text(exports / "usda" / "heap.usda");
  EXPECT_THAT(usd, HasSubstr("def PointInstancer \"heap_grains\""));
  EXPECT_THAT(usd, HasSubstr("def Mesh \"grain\""));
  EXPECT_THAT(usd, HasSubstr("int[] faceVertexCounts = [3, 3, 3, 3, 3, 3, 3, 3]"));
  const Frame second = frame(2);
  const FrameBody& grains = grains_of(second);
  const SceneBody body = cache().read_static()->bodies.at(1);
  const std::vector<double>&x = find_channel(grains, "position")->values,
        &q = find_channel(grains, "orientation")->values, &size = find_channel(grains, "size")->values;
  std::istringstream obj(read_text(exports / "obj" / "heap_grains.0002.obj"));
  std::string line;
  std::size_t vertex = 0, faces = 0;
  double worst = 0.0;
  while (std::getline(obj, line)) {
    faces += line.starts_with("f ") ? 1 : 0;
    if (!line.starts_with("v "))
      continue;
    std::istringstream numbers(line.substr(2));
    Vec3 found;
    numbers >> found[0] >> found[1] >> found[2];
    const std::size_t i = vertex / 6;
    const Mat3 R = rotation_matrix(Vec4(q[4 * i], q[4 * i + 1], q[4 * i + 2], q[4 * i + 3]));
    const Vec3 rest = body.rest_positions.row(static_cast<Eigen::Index>(vertex++ % 6));
    const Vec3 lengths(size[3 * i], size[3 * i + 1], size[3 * i + 2]);
    worst =
        std::max(worst, (Vec3(x[3 * i], x[3 * i + 1], x[3 * i + 2]) + R * lengths.cwiseProduct(rest) - found).norm());
  }
  EXPECT_EQ(vertex, x.size() / 3 * 6);
  EXPECT_EQ(faces, x.size() / 3 * 8);
  EXPECT_LT(worst, 1e-6);
}

TEST_F(GrainMesh, AChangedMeshMakesTheFramesStale) {
  ASSERT_EQ(wry("simulate", {"--frames", "1"}).exit_code, 0);
  const std::vector<std::string> before = frame_hashes(m_folder.path() / "o");
  std::string longer = WEDGE;
  for (std::size_t at = longer.find(".03"); at != std::string::npos; at = longer.find(".03", at + 1))
    longer.replace(at, 3, ".05");
  write_text(m_folder.path() / "wedge.ply", longer);
  ASSERT_EQ(wry("simulate", {"--frames", "1"}).exit_code, 0);
  EXPECT_NE(frame_hashes(m_folder.path() / "o"), before);
}

TEST_F(GrainMesh, WhatIsNoMeshIsRefusedWithItsLine) {
  const Outcome missing = wry("plan", {"--set", "body.heap.sub_particles.mesh=nowhere.ply"});
  EXPECT_EQ(missing.exit_code, 66) << missing.err;
  EXPECT_THAT(missing.err, HasSubstr("nowhere.ply"));
  const std::string no_faces = WEDGE.substr(0, WEDGE.find("element face")) + "end_header\n" +
                               WEDGE.substr(WEDGE.find("0 0 0"), WEDGE.find("3 0 2 1") - WEDGE.find("0 0 0"));
  write_text(m_folder.path() / "wedge.ply", no_faces);
  const Outcome points = wry("plan");
  EXPECT_EQ(points.exit_code, 65) << points.err;
  EXPECT_THAT(points.err, HasSubstr("heap.toml:9:"));
  const auto with = [&](const std::string& in_place_of_mesh) {
    std::string text = HEAP;
    const std::string mesh = "mesh = \"wedge.ply\"";
    text.replace(text.find(mesh), mesh.size(), in_place_of_mesh);
    write_text(m_folder.path() / "heap.toml", text);
    return wry("plan");
  };
  const Outcome shapeless = with("seed = 2");
  EXPECT_EQ(shapeless.exit_code, 65) << shapeless.err;
  EXPECT_THAT(shapeless.err, HasSubstr("sub_particles.size is missing"));
  const Outcome both = with("shape = \"rod\", mesh = \"wedge.ply\"");
  EXPECT_EQ(both.exit_code, 65) << both.err;
  EXPECT_THAT(both.err, HasSubstr("keep one of the two"));
}

} // namespace
} // namespace wry::cli_test
