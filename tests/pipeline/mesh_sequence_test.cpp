#include <cstring>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/assets/mesh_sequence_import.h"
#include "pipeline/assets/numbered_vertices.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryFolder;

template <class T> void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// A square of two triangles at a height; its corners are listed against the order of the faces, the last one twice.
std::string square(double height, double seam = 0.0) {
  return fmt::format("# a square\nv 0 {0} 0\r\nv 1 {0} 0 1.0\nvt 0 0\nv 1 {0} 1\nv 0 {0} +1\nv {1} {0} 1\n"
                     "f 5/1 3//1 2\nf 1 -1 2\n",
                     height, seam);
}

/// What import and welding make of it: in the order of the faces.
Points welded() {
  Points points(4, 3);
  points << 0, 0, 1, 1, 0, 1, 1, 0, 0, 0, 0, 0;
  return points;
}

/// One coordinate of all vertices.
Eigen::Vector4d column(const ImportedMeshSequence& made, std::size_t sample, int axis) {
  return made.samples[sample].col(axis);
}

class MeshSequence : public ::testing::Test {
protected:
  MeshSequence() { write("square.obj", square(0.0)); }
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(m_folder.path() / name, std::ios::binary) << bytes;
  }
  std::string path(const std::string& name) const { return (m_folder.path() / name).string(); }
  Result<ImportedMeshSequence> read(const std::string& sequence, int first, int last) const {
    MeshSequenceSource source;
    source.mesh = path("square.obj");
    source.sequence = path(sequence);
    source.placements = {{2.0, Mat3::Identity(), Vec3::Zero()}, {1.0, Mat3::Identity(), Vec3(0, 0, 10)}};
    source.first_frame = first;
    source.last_frame = last;
    Points placed = 2.0 * welded();
    placed.col(2).array() += 10.0;
    return import_mesh_sequence(source, placed);
  }
  std::string error(const std::string& sequence, int first, int last) const {
    const Result<ImportedMeshSequence> read_one = read(sequence, first, last);
    return read_one ? "" : read_one.error().message;
  }
  /// The five vertices of the file, at heights 0, 10, 20, ... plus 100 for each sample before.
  std::string point_cache(float first, float step, int samples, int points = 5) const {
    std::string bytes("POINTCACHE2\0", 12);
    append(bytes, std::int32_t{1});
    append(bytes, std::int32_t{points});
    append(bytes, first);
    append(bytes, step);
    append(bytes, std::int32_t{samples});
    for (int sample = 0; sample < samples; ++sample) {
      for (int i = 0; i < points; ++i) {
        append(bytes, 0.0F);
        append(bytes, static_cast<float>(10 * std::min(i, 3) + 100 * sample));
        append(bytes, 0.0F);
      }
    }
    return bytes;
  }
  TemporaryFolder m_folder;
};

TEST_F(MeshSequence, APointCacheMovesTheVerticesThatTheFileNumbers) {
  write("square.pc2", point_cache(5.0F, 0.5F, 11));
  const Result<ImportedMeshSequence> made = read("square.pc2", 5, 10);
  ASSERT_TRUE(made.ok()) << made.error().message;
  ASSERT_EQ(made->samples.size(), 11u);
  EXPECT_EQ(made->first_frame, 5.0);
  EXPECT_EQ(made->frames_per_sample, 0.5);
  // The first welded vertex is the fourth (and fifth) of the file, then the third, the second and the first; placed.
  EXPECT_EQ(column(*made, 0, 1), Eigen::Vector4d(60, 40, 20, 0));
  EXPECT_EQ(column(*made, 2, 1), Eigen::Vector4d(460, 440, 420, 400));
  EXPECT_EQ(column(*made, 0, 2), Eigen::Vector4d(10, 10, 10, 10));
}

TEST_F(MeshSequence, NumberedMeshesAreReadFrameByFrame) {
  for (int frame = 7; frame <= 9; ++frame)
    write(fmt::format("wave.{:04}.obj", frame), square(frame));
  const Result<ImportedMeshSequence> made = read("wave.####.obj", 7, 9);
  ASSERT_TRUE(made.ok()) << made.error().message;
  ASSERT_EQ(made->samples.size(), 3u);
  EXPECT_EQ(made->first_frame, 7.0);
  for (std::size_t i = 0; i < 3; ++i) {
    const double height = 2.0 * (7.0 + static_cast<double>(i));
    EXPECT_EQ(column(*made, i, 1), Eigen::Vector4d(height, height, height, height));
  }
  EXPECT_EQ(made->files.size(), 3u);
  EXPECT_EQ(made->files[1], path("wave.0008.obj"));
}

TEST_F(MeshSequence, FramesThatAreNotThereAreNamed) {
  write("wave.0007.obj", square(1.0));
  EXPECT_THAT(error("wave.####.obj", 7, 9), HasSubstr("wave.0008.obj for frame 8; the shot has frames 7 to 9"));
  write("short.pc2", point_cache(1.0F, 1.0F, 10));
  EXPECT_TRUE(read("short.pc2", 1, 10).ok());
  EXPECT_THAT(error("short.pc2", 1, 11), HasSubstr("holds frames 1 to 10, but the shot has 1 to 11"));
  EXPECT_THAT(error("short.pc2", 0, 5), HasSubstr("holds frames 1 to 10, but the shot has 0 to 5"));
  EXPECT_THAT(error("none.pc2", 1, 2), HasSubstr("none.pc2"));
}

TEST_F(MeshSequence, OtherVerticesOrFacesThanTheMeshHasAreRefused) {
  write("a.1.obj", square(1.0) + "v 0 0 0\n");
  EXPECT_THAT(error("a.#.obj", 1, 1), HasSubstr("has 6 vertices, the mesh"));
  std::string turned = square(1.0);
  turned.replace(turned.find("f 1 -1 2"), 8, "f 1 -1 3");
  write("a.2.obj", turned);
  EXPECT_THAT(error("a.#.obj", 2, 2), HasSubstr("its faces are not those of the mesh"));
  write("four.pc2", point_cache(1.0F, 1.0F, 2, 4));
  EXPECT_THAT(error("four.pc2", 1, 2), HasSubstr("moves 4 points, the mesh has 5"));
}

TEST_F(MeshSequence, ASeamThatOpensIsRefused) {
  write("a.1.obj", square(1.0, 0.0));
  EXPECT_TRUE(read("a.#.obj", 1, 1).ok());
  write("a.1.obj", square(1.0, 0.1));
  EXPECT_THAT(error("a.#.obj", 1, 1), HasSubstr("vertices 3 and 4 are at one place in the mesh, but 0.2 m apart"));
}

TEST_F(MeshSequence, NamesThatAreNoSequenceAreRefused) {
  EXPECT_THAT(error("wave.obj", 1, 1), HasSubstr("write one # for each digit"));
  EXPECT_THAT(error("wave.##.#.obj", 1, 1), HasSubstr("write one # for each digit"));
  write("wave.1.stl", "solid\nendsolid\n");
  EXPECT_THAT(error("wave.#.stl", 1, 1), HasSubstr("only .obj and .ply files"));
}

TEST_F(MeshSequence, DamagedObjFilesAreRefusedWithTheLine) {
  for (const char* bad : {"v 1 2\n", "v 1 2 x\n", "v 1 2 nan\n", "v 1 2 1e999\n", "f 1 2 3\n", "v 0 0 0\nf 1 2\n",
                          "v 0 0 0\nf 0\n", "v 0 0 0\nf -2\n", "v 0 0 0\nf a\n", "v 0 0 0\nf 99999999999999999999\n"}) {
    write("bad.obj", bad);
    const Result<NumberedVertices> read_one = read_numbered_vertices(path("bad.obj"));
    ASSERT_FALSE(read_one.ok()) << bad;
    EXPECT_EQ(read_one.error().code, ErrorCode::bad_input);
    EXPECT_THAT(read_one.error().message, HasSubstr("line ")) << bad;
  }
  write("bad.obj", "");
  EXPECT_THAT(read_numbered_vertices(path("bad.obj")).error().message, HasSubstr("no vertices"));
}

TEST_F(MeshSequence, PlyKeepsItsOrderToo) {
  write("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                 "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 5 0\n3 2 1 0\n");
  const Result<NumberedVertices> read_one = read_numbered_vertices(path("a.ply"));
  ASSERT_TRUE(read_one.ok()) << read_one.error().message;
  ASSERT_EQ(read_one->positions.rows(), 3);
  EXPECT_EQ(read_one->positions(2, 1), 5.0);
}

} // namespace
} // namespace wry::pipeline
