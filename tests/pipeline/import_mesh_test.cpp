#include "pipeline/assets/mesh_import.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "sim/geometry/primitives.h"
#include "tests/pipeline/import_files_support.h"

namespace wry::pipeline {
namespace {

using geometry::Axis;

geometry::SurfaceMesh cone() {
  // No symmetry, so that a wrong axis or a mirror shows: a torus squeezed along y and moved.
  geometry::SurfaceMesh mesh = geometry::make_torus(1.0, 0.3, Axis::y, 0.2).value();
  mesh.vertices.col(1) *= 0.5;
  mesh.vertices.rowwise() += Eigen::RowVector3d(0.1, 0.2, 0.3);
  return mesh;
}

bool is_here(const std::string& kind) {
  TemporaryFolder folder;
  const Result<ImportedMesh> mesh = import_mesh(folder.write("m" + extension_of(kind), mesh_file_bytes(cone(), kind)));
  return mesh || mesh.error().code != ErrorCode::unavailable;
}

class EveryKind : public testing::TestWithParam<const char*> {
protected:
  void SetUp() override {
    if (!is_here(GetParam()))
      GTEST_SKIP() << "not in this build";
  }
  TemporaryFolder m_folder;
};

TEST_P(EveryKind, ArrivesClosedOutwardAndOfTheSameVolume) {
  const std::string kind = GetParam();
  const geometry::SurfaceMesh original = cone();
  const std::string path = m_folder.write("thing" + extension_of(kind), mesh_file_bytes(original, kind));
  MeshImportOptions options;
  options.closedness = Closedness::closed;
  options.node = kind == "glb" ? "left" : "";
  const Result<ImportedMesh> imported = import_mesh(path, options);
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_TRUE(imported->report.is_manifold());
  EXPECT_TRUE(imported->report.is_oriented());
  EXPECT_EQ(imported->mesh.vertices.rows(), original.vertices.rows());
  EXPECT_EQ(imported->mesh.triangles.rows(), original.triangles.rows());
  const geometry::MeshReport expected = geometry::inspect_mesh(original);
  EXPECT_NEAR(imported->report.volume, expected.volume, 1e-6);
  EXPECT_LT((imported->report.lower - expected.lower).norm(), 1e-6);
  EXPECT_LT((imported->report.upper - expected.upper).norm(), 1e-6);
  ASSERT_FALSE(imported->notes.empty());
  EXPECT_NE(imported->notes[0].find("2.593 x 0.2853 x 2.6 m"), std::string::npos) << imported->notes[0];
}

TEST_P(EveryKind, InsideOutFilesAreTurned) {
  geometry::SurfaceMesh mesh = cone();
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  const std::string kind = GetParam();
  MeshImportOptions options;
  options.node = kind == "glb" ? "left" : "";
  const Result<ImportedMesh> imported =
      import_mesh(m_folder.write("thing" + extension_of(kind), mesh_file_bytes(mesh, kind)), options);
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_NEAR(imported->report.volume, geometry::inspect_mesh(cone()).volume, 1e-6);
}

TEST_P(EveryKind, CutShortFilesAreErrorsOrSaySo) {
  const std::string kind = GetParam();
  const std::string whole = mesh_file_bytes(cone(), kind);
  for (const double part : {0.0, 0.02, 0.3, 0.5, 0.77, 0.95}) {
    const std::string bytes = whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size())));
    MeshImportOptions options;
    options.closedness = Closedness::closed;
    const Result<ImportedMesh> imported = import_mesh(m_folder.write("cut" + extension_of(kind), bytes), options);
    ASSERT_FALSE(imported) << part;
    EXPECT_EQ(imported.error().code, ErrorCode::bad_input) << imported.error().message;
    EXPECT_NE(imported.error().message.find("cut" + extension_of(kind)), std::string::npos) << imported.error().message;
  }
}

INSTANTIATE_TEST_SUITE_P(Import, EveryKind,
                         testing::Values("obj", "stl", "stl-ascii", "off", "glb", "ply-ascii", "ply-little", "ply-big"),
                         [](const auto& parameter) {
                           std::string name = parameter.param;
                           name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
                           return name;
                         });

TEST(ImportMesh, UnitsAndUpAxisAreApplied) {
  TemporaryFolder folder;
  const std::string path = folder.write("thing.ply", mesh_file_bytes(cone(), "ply-little"));
  MeshImportOptions options;
  options.metres_per_unit = 0.01;
  options.up = Axis::z;
  options.scene_up = Axis::y;
  const Result<ImportedMesh> imported = import_mesh(path, options);
  ASSERT_TRUE(imported) << imported.error().message;
  const geometry::MeshReport original = geometry::inspect_mesh(cone());
  EXPECT_NEAR(imported->report.upper.y(), 0.01 * original.upper.z(), 1e-8);
  EXPECT_NEAR(imported->report.upper.z(), -0.01 * original.lower.y(), 1e-8);
  EXPECT_NEAR(imported->report.volume, 1e-6 * original.volume, 1e-11);
}

TEST(ImportMesh, AttributesComeAlong) {
  TemporaryFolder folder;
  for (const char* kind : {"ply-ascii", "ply-little", "ply-big"}) {
    const Result<ImportedMesh> imported = import_mesh(folder.write("thing.ply", mesh_file_bytes(cone(), kind)));
    ASSERT_TRUE(imported) << imported.error().message;
    ASSERT_EQ(imported->mesh.attributes.size(), 2u);
    EXPECT_EQ(imported->mesh.attributes[0].name, "colour");
    EXPECT_EQ(imported->mesh.attributes[0].components, 3);
    EXPECT_EQ(imported->mesh.attributes[0].values[3], 1.0);
    EXPECT_NEAR(imported->mesh.attributes[0].values[4], 0.2, 1e-15);
    EXPECT_EQ(imported->mesh.attributes[1].name, "stiffness");
    EXPECT_EQ(imported->mesh.attributes[1].values[7], 7.0);
  }
}

TEST(ImportMesh, NodeTransformsAreAppliedAndNodesChosen) {
  if (!is_here("glb"))
    GTEST_SKIP() << "not in this build";
  TemporaryFolder folder;
  const std::string path = folder.write("pair.glb", mesh_file_bytes(cone(), "glb"));
  const geometry::MeshReport original = geometry::inspect_mesh(cone());
  const Result<ImportedMesh> both = import_mesh(path);
  ASSERT_TRUE(both) << both.error().message;
  EXPECT_EQ(both->report.components, 2);
  EXPECT_NEAR(both->report.volume, 2 * original.volume, 1e-5);
  EXPECT_NEAR(both->report.upper.x(), 10 - original.lower.x(), 1e-5);
  MeshImportOptions options;
  options.node = "right";
  const Result<ImportedMesh> right = import_mesh(path, options);
  ASSERT_TRUE(right) << right.error().message;
  EXPECT_NEAR(right->report.lower.x(), 10 - original.upper.x(), 1e-5);
  // The mirroring node was undone triangle by triangle: nothing was left to turn.
  for (const std::string& note : right->notes)
    EXPECT_EQ(note.find("turned"), std::string::npos) << note;
  options.node = "middle";
  const Result<ImportedMesh> middle = import_mesh(path, options);
  ASSERT_FALSE(middle);
  EXPECT_NE(middle.error().message.find("no node 'middle'"), std::string::npos) << middle.error().message;
  EXPECT_NE(middle.error().message.find("left"), std::string::npos) << middle.error().message;
}

TEST(ImportMesh, PolygonsIncludingConcaveOnesAreCut) {
  TemporaryFolder folder;
  const std::string path =
      folder.write("star.ply", "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
                               "property float z\nelement face 1\nproperty list uchar int vertex_index\n"
                               "end_header\n4 0 0\n1 0 1\n0 0 4\n-1 0 1\n-4 0 0\n-1 0 -1\n0 0 -4\n1 0 -1\n"
                               "8 0 7 6 5 4 3 2 1\n");
  const Result<ImportedMesh> imported = import_mesh(path);
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(imported->mesh.triangles.rows(), 6);
  EXPECT_NEAR(imported->report.area, 16, 1e-12); // the star's: half of |x y' - x' y| around it
  EXPECT_EQ(imported->report.boundary_loops, 1);
}

TEST(ImportMesh, HolesAreNamedWhereClosedIsNeeded) {
  TemporaryFolder folder;
  geometry::SurfaceMesh mesh = cone();
  mesh.triangles.conservativeResize(mesh.triangles.rows() - 1, 3);
  const std::string path = folder.write("open.ply", mesh_file_bytes(mesh, "ply-little"));
  EXPECT_TRUE(import_mesh(path));
  MeshImportOptions options;
  options.closedness = Closedness::closed;
  const Result<ImportedMesh> imported = import_mesh(path, options);
  ASSERT_FALSE(imported);
  EXPECT_NE(imported.error().message.find("open.ply is not closed: 1 hole, the longest has 3 edges"), std::string::npos)
      << imported.error().message;
}

TEST(ImportMesh, MissingFilesFoldersAndUnknownFormatsAreSaid) {
  TemporaryFolder folder;
  EXPECT_EQ(import_mesh("/nowhere/bunny.obj").error().code, ErrorCode::missing_input);
  EXPECT_EQ(import_mesh("/tmp").error().code, ErrorCode::bad_input);
  const Result<ImportedMesh> unknown = import_mesh(folder.write("scene.blend", "BLENDER"));
  EXPECT_EQ(unknown.error().code, ErrorCode::bad_input);
  EXPECT_NE(unknown.error().message.find("obj, stl"), std::string::npos);
  const std::string pipe = folder.write("pipe.ply", "");
  std::filesystem::remove(pipe);
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(import_mesh(pipe).error().code, ErrorCode::bad_input);
}

TEST(ImportMesh, DamagedObjNamesTheLine) {
  if (!is_here("obj"))
    GTEST_SKIP() << "not in this build";
  TemporaryFolder folder;
  const auto error_of = [&](const std::string& text) {
    const Result<ImportedMesh> imported = import_mesh(folder.write("m.obj", text));
    return imported ? "it was accepted" : imported.error().message;
  };
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_NE(error_of(triangle + "f 1 2 4\n").find("line 4: a face names vertex 4, but the file has only 3"),
            std::string::npos);
  EXPECT_NE(error_of(triangle + "f 1 2").find("line 4: a face needs three corners, it has 2"), std::string::npos);
  EXPECT_NE(error_of(triangle + "f -1 -2 -9\n").find("line 4"), std::string::npos);
  EXPECT_NE(error_of("v 0 0\n").find("line 1: a vertex needs three numbers"), std::string::npos);
  EXPECT_NE(error_of(triangle).find("no faces"), std::string::npos);
  EXPECT_NE(error_of("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").find("m.obj"), std::string::npos);
  EXPECT_TRUE(import_mesh(folder.write("m.obj", triangle + "f 1//1 2//1 3/ # comment\n")).ok());
  EXPECT_TRUE(import_mesh(folder.write("m.obj", triangle + "f -3 -2 -1")).ok());
}

TEST(ImportMesh, DamagedPlyNamesThePlace) {
  TemporaryFolder folder;
  const auto error_of = [&](const std::string& text) {
    const Result<ImportedMesh> imported = import_mesh(folder.write("m.ply", text));
    return imported ? "it was accepted" : imported.error().message;
  };
  const auto ply = [](const std::string& counts, const std::string& data) {
    return "ply\nformat ascii 1.0\nelement vertex " + counts.substr(0, counts.find(' ')) +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
           counts.substr(counts.find(' ') + 1) + "\nproperty list uchar int vertex_indices\nend_header\n" + data;
  };
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_TRUE(import_mesh(folder.write("m.ply", ply("3 1", points + "3 0 1 2"))).ok());
  EXPECT_NE(error_of(ply("3 1", points + "3 0 1 7")).find("names vertex 7"), std::string::npos);
  EXPECT_NE(error_of(ply("3 1", points + "3 0 1 -1")).find("no vertex index"), std::string::npos);
  EXPECT_NE(error_of(ply("3 1", points + "3 0 1")).find("face 1 of 1: line 13: a list of 3 values does not fit"),
            std::string::npos)
      << error_of(ply("3 1", points + "3 0 1"));
  EXPECT_NE(error_of(ply("4000000000 1", points)).find("promises"), std::string::npos);
  EXPECT_NE(error_of(ply("18446744073709551615 1", points)).find("promises"), std::string::npos);
  EXPECT_NE(error_of(ply("3 1", "0 0 nan\n1 0 0\n0 1 0\n3 0 1 2")).find("not finite"), std::string::npos);
  EXPECT_NE(error_of(ply("3 1", "0 0 1e999\n1 0 0\n0 1 0\n3 0 1 2")).find("not finite"), std::string::npos);
  EXPECT_NE(error_of(ply("3 1", "0 0 zero\n1 0 0\n0 1 0\n3 0 1 2")).find("line 10: not a number"), std::string::npos);
  EXPECT_NE(error_of(ply("3 1", points + "200000 1 2 3")).find("does not fit"), std::string::npos);
  EXPECT_NE(error_of(ply("3 0", points)).find("no faces"), std::string::npos);
  EXPECT_NE(error_of("ply\nformat ascii 2.0\nend_header\n").find("line 2"), std::string::npos);
  EXPECT_NE(error_of("ply\nformat ascii 1.0\n").find("before 'end_header'"), std::string::npos);
  EXPECT_NE(error_of("ply\nend_header\n").find("no format"), std::string::npos);
  EXPECT_NE(error_of("plyx").find("begins with 'ply'"), std::string::npos);
}

#if !defined(__SANITIZE_ADDRESS__)
TEST(ImportMesh, FilesTooLargeForTheMemoryLimitAreErrorsThatNameIt) {
  TemporaryFolder folder;
  const std::string path =
      folder.write("huge.ply", mesh_file_bytes(geometry::make_sphere(1.0, 0.02).value(), "ply-little"));
  MeshImportOptions options;
  ASSERT_TRUE(import_mesh(path, options));
  // The program with its libraries takes some of it; a stand-in tells how much is just enough to start.
  for (options.limits.memory_bytes = 8 << 20;
       !import_mesh(folder.write("m.ply", mesh_file_bytes(cone(), "ply-little")), options);)
    options.limits.memory_bytes += 8 << 20;
  const Result<ImportedMesh> starved = import_mesh(path, options);
  ASSERT_FALSE(starved);
  EXPECT_EQ(starved.error().code, ErrorCode::bad_input);
  EXPECT_NE(starved.error().message.find("MiB of memory"), std::string::npos) << starved.error().message;
}
#endif

} // namespace
} // namespace wry::pipeline
