#include "sim/geometry/msh_import.h"

#include <chrono>
#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "sim/geometry/structured_tets.h"

namespace wry::geometry {
namespace {

TetMesh bar() {
  return make_block_tets(box_block({1, 1, 2}), BlockCells{{2, 2, 3}, CellSplit::five}).value();
}

// The mesh as Gmsh writes it: nodes numbered from `first` upwards in steps of 3, a point, a line and a triangle before
// the tets, and one node that nothing uses.
std::string msh_text(const TetMesh& mesh, double version, std::int64_t first = 1) {
  const auto tag = [&](std::int32_t v) { return first + 3 * static_cast<std::int64_t>(v); };
  const auto nodes = mesh.vertices.rows();
  std::string text =
      fmt::format("$MeshFormat\n{} 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"body\"\n$EndPhysicalNames\n", version);
  const auto position = [&](Eigen::Index v) {
    return fmt::format("{:.17g} {:.17g} {:.17g}\n", mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2));
  };
  if (version == 2.2) {
    text += fmt::format("$Nodes\n{}\n{} 9 9 9\n", nodes + 1, tag(static_cast<std::int32_t>(nodes)));
    for (Eigen::Index v = nodes - 1; v >= 0; --v)
      text += fmt::format("{} {}", tag(static_cast<std::int32_t>(v)), position(v));
    text += fmt::format("$EndNodes\n$Elements\n{}\n1 15 2 0 1 {}\n2 1 2 0 1 {} {}\n3 2 2 0 1 {} {} {}\n",
                        mesh.tets.rows() + 3, tag(0), tag(0), tag(1), tag(0), tag(1), tag(2));
    for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
      text += fmt::format("{} 4 2 1 1 {} {} {} {}\n", t + 4, tag(mesh.tets(t, 0)), tag(mesh.tets(t, 1)),
                          tag(mesh.tets(t, 2)), tag(mesh.tets(t, 3)));
    return text + "$EndElements\n";
  }
  text += fmt::format(
      "$Entities\n0 0 0 1\n1 0 0 0 1 1 2 0 0\n$EndEntities\n$Nodes\n2 {} 1 99999\n0 1 0 1\n{}\n9 9 9\n3 1 0 {}\n",
      nodes + 1, tag(static_cast<std::int32_t>(nodes)), nodes);
  for (Eigen::Index v = nodes - 1; v >= 0; --v)
    text += fmt::format("{}\n", tag(static_cast<std::int32_t>(v)));
  for (Eigen::Index v = nodes - 1; v >= 0; --v)
    text += position(v);
  text += fmt::format("$EndNodes\n$Elements\n2 {} 1 {}\n2 1 2 1\n1 {} {} {}\n3 1 4 {}\n", mesh.tets.rows() + 1,
                      mesh.tets.rows() + 1, tag(0), tag(1), tag(2), mesh.tets.rows());
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    text += fmt::format("{} {} {} {} {}\n", t + 2, tag(mesh.tets(t, 0)), tag(mesh.tets(t, 1)), tag(mesh.tets(t, 2)),
                        tag(mesh.tets(t, 3)));
  return text + "$EndElements\n";
}

double volume(const TetMesh& mesh, Eigen::Index t) {
  const auto p = [&](int k) { return Vec3(mesh.vertices.row(mesh.tets(t, k)).transpose()); };
  return (p(1) - p(0)).cross(p(2) - p(0)).dot(p(3) - p(0)) / 6;
}

std::string error_of(const std::string& text) {
  const Result<MshMesh> mesh = parse_msh(text);
  EXPECT_FALSE(mesh);
  if (mesh)
    return "";
  EXPECT_EQ(mesh.error().code, ErrorCode::bad_input);
  return mesh.error().message;
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

TEST(MshImport, BothVersionsKeepEveryTetAndDropUnusedNodes) {
  const TetMesh original = bar();
  for (const double version : {2.2, 4.1}) {
    const Result<MshMesh> msh = parse_msh(msh_text(original, version, 4'000'000'000'000));
    ASSERT_TRUE(msh) << msh.error().message;
    EXPECT_EQ(msh->mesh.tets.rows(), original.tets.rows());
    EXPECT_EQ(msh->mesh.vertices.rows(), original.vertices.rows());
    EXPECT_EQ(msh->unused_vertices, 1);
    EXPECT_EQ(msh->turned_tets, 0);
    for (Eigen::Index t = 0; t < original.tets.rows(); ++t)
      for (int k = 0; k < 4; ++k)
        EXPECT_EQ(msh->mesh.vertices.row(msh->mesh.tets(t, k)), original.vertices.row(original.tets(t, k)));
  }
}

TEST(MshImport, InvertedTetsAreTurned) {
  TetMesh mesh = bar();
  for (const Eigen::Index t : {0, 7, 30})
    std::swap(mesh.tets(t, 0), mesh.tets(t, 1));
  const Result<MshMesh> msh = parse_msh(msh_text(mesh, 4.1));
  ASSERT_TRUE(msh);
  EXPECT_EQ(msh->turned_tets, 3);
  for (Eigen::Index t = 0; t < msh->mesh.tets.rows(); ++t)
    EXPECT_GT(volume(msh->mesh, t), 0);
}

TEST(MshImport, WindowsLineEndsAndSecondOrderTetsAreRead) {
  const std::string text =
      "$MeshFormat\r\n2.2 0 8\r\n$EndMeshFormat\r\n$Nodes\r\n4\r\n1 0 0 0\r\n2 1 0 0\r\n3 0 1 0\r\n4 0 0 1\r\n"
      "$EndNodes\r\n$Elements\r\n1\r\n1 11 2 0 1 1 2 3 4 1 2 3 4 1 2\r\n$EndElements\r\n";
  const Result<MshMesh> msh = parse_msh(text);
  ASSERT_TRUE(msh) << msh.error().message;
  EXPECT_EQ(msh->second_order_tets, 1);
  EXPECT_NEAR(volume(msh->mesh, 0), 1.0 / 6, 1e-15);
}

TEST(MshImport, ErrorsNameTheLine) {
  const std::string good =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n"
      "$EndNodes\n$Elements\n1\n1 4 2 0 1 1 2 3 4\n$EndElements\n";
  ASSERT_TRUE(parse_msh(good));
  EXPECT_NE(error_of(replaced(good, "2.2 0", "4.0 0")).find("line 2: version 4"), std::string::npos);
  EXPECT_NE(error_of(replaced(good, "2.2 0", "2.2 1")).find("line 2: binary"), std::string::npos);
  EXPECT_NE(error_of(replaced(good, "3 0 1 0", "3 0 nan 0")).find("line 8: the position of node 3"), std::string::npos);
  EXPECT_NE(error_of(replaced(good, "3 0 1 0", "3 0 1e999 0")).find("line 8"), std::string::npos);
  EXPECT_NE(error_of(replaced(good, "3 0 1 0", "3 0 x 0")).find("line 8: a coordinate is no number"),
            std::string::npos);
  EXPECT_NE(error_of(replaced(good, "3 0 1 0", "3 0")).find("line 8: a coordinate is missing"), std::string::npos);
  EXPECT_NE(error_of(replaced(good, "3 0 1 0", "2 0 1 0")).find("line 8: node 2 is there already, on line 7"),
            std::string::npos);
  EXPECT_NE(error_of(replaced(good, "1 2 3 4\n", "1 2 3 9\n")).find("line 14: the tet names node 9"),
            std::string::npos);
  EXPECT_NE(error_of(replaced(good, "1 2 3 4\n", "1 2 3 3\n")).find("line 14: the tet names node 3 twice"),
            std::string::npos);
  EXPECT_NE(error_of(replaced(good, "1 2 3 4\n", "1 2 3\n")).find("line 14"), std::string::npos);
  EXPECT_NE(error_of(replaced(good, "4 0 0 1", "4 1 1 0")).find("line 14: the tet of nodes 1, 2, 3, 4 has no volume"),
            std::string::npos);
  EXPECT_NE(error_of(replaced(good, "1 4 2 0", "1 5 2 0")).find("type 5 are not tets"), std::string::npos);
  EXPECT_NE(
      error_of(replaced(good, "$Nodes\n5", "$Nodes\n5000000000000")).find("line 5: 5000000000000 nodes are promised"),
      std::string::npos);
  EXPECT_NE(error_of(replaced(good, "$Nodes\n5", "$Nodes\n4")).find("$EndNodes should stand here"), std::string::npos);
  EXPECT_NE(error_of(replaced(good, "$Elements\n1\n", "$Elements\n-1\n")).find("line 13"), std::string::npos);
  EXPECT_NE(error_of("hello").find("$MeshFormat"), std::string::npos);
  EXPECT_NE(error_of("").find("$MeshFormat"), std::string::npos);
  EXPECT_NE(error_of(good.substr(0, good.find("$Elements"))).find("no tets"), std::string::npos);
  const std::string three = replaced(good, "$Elements\n1\n1 4 2 0 1 1 2 3 4\n",
                                     "$Elements\n3\n1 4 2 0 1 1 2 3 4\n2 4 2 0 1 1 2 3 5\n3 4 2 0 1 3 1 2 4\n");
  EXPECT_NE(error_of(three).find("line 16: a face of this tet belongs to two others already, on lines 14 and 15"),
            std::string::npos)
      << error_of(three);
}

TEST(MshImport, TruncationsAndMutationsNeverCrashAndStayFast) {
  const auto begin = std::chrono::steady_clock::now();
  std::mt19937 random(11);
  int accepted = 0;
  int refused = 0;
  for (const double version : {2.2, 4.1}) {
    const std::string good = msh_text(bar(), version);
    const std::size_t last = good.rfind("$End");
    for (std::size_t length = 0; length < last; length += 37)
      EXPECT_FALSE(parse_msh(good.substr(0, length))) << length;
    for (int i = 0; i < 2000; ++i) {
      std::string damaged = good;
      for (int k = 0; k < 3; ++k) {
        const std::size_t at = random() % damaged.size();
        const int kind = static_cast<int>(random() % 4);
        if (kind == 0)
          damaged[at] = static_cast<char>(random() % 256);
        else if (kind == 1)
          damaged.insert(at, "99999999999999");
        else if (kind == 2)
          damaged.erase(at, random() % 40);
        else
          damaged[at] = '-';
      }
      const Result<MshMesh> msh = parse_msh(damaged);
      (msh ? accepted : refused) += 1;
      if (!msh)
        continue;
      EXPECT_GE(msh->mesh.tets.minCoeff(), 0);
      EXPECT_LT(msh->mesh.tets.maxCoeff(), msh->mesh.vertices.rows());
      for (Eigen::Index t = 0; t < msh->mesh.tets.rows(); ++t)
        EXPECT_GT(volume(msh->mesh, t), 0);
    }
  }
  EXPECT_GT(refused, accepted);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  RecordProperty("accepted", accepted);
  RecordProperty("refused", refused);
}

TEST(MshImport, MissingFilesAreMissing) {
  EXPECT_EQ(read_msh("/nowhere/a.msh").error().code, ErrorCode::missing_input);
  EXPECT_EQ(import_tets("/nowhere/a.msh").error().code, ErrorCode::missing_input);
}

} // namespace
} // namespace wry::geometry
