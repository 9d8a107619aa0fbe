#include "sim/geometry/structured_tets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "sim/geometry/mesh_checks.h"

namespace wry::geometry {
namespace {

constexpr CellSplit SPLITS[] = {CellSplit::five,         CellSplit::kuhn,   CellSplit::kuhn_mirrored,
                                CellSplit::kuhn_outward, CellSplit::twelve, CellSplit::twenty_four};

std::array<Vec3, 4> corners(const TetMesh& mesh, Eigen::Index tet) {
  std::array<Vec3, 4> points;
  for (int k = 0; k < 4; ++k)
    points[k] = mesh.vertices.row(mesh.tets(tet, k)).transpose();
  return points;
}

double volume(const TetMesh& mesh, Eigen::Index tet) {
  const auto [a, b, c, d] = corners(mesh, tet);
  return (b - a).cross(c - a).dot(d - a) / 6;
}

double total_volume(const TetMesh& mesh) {
  double sum = 0;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    sum += volume(mesh, t);
  return sum;
}

double smallest_volume(const TetMesh& mesh) {
  double smallest = volume(mesh, 0);
  for (Eigen::Index t = 1; t < mesh.tets.rows(); ++t)
    smallest = std::min(smallest, volume(mesh, t));
  return smallest;
}

// Smallest and largest angle between two faces of a tet [deg].
std::pair<double, double> dihedral_range(const TetMesh& mesh) {
  double smallest = 180;
  double largest = 0;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    const std::array<Vec3, 4> p = corners(mesh, t);
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        int others[2];
        int count = 0;
        for (int k = 0; k < 4; ++k)
          if (k != i && k != j)
            others[count++] = k;
        const Vec3 edge = (p[j] - p[i]).normalized();
        Vec3 a = p[others[0]] - p[i];
        Vec3 b = p[others[1]] - p[i];
        a -= edge * edge.dot(a);
        b -= edge * edge.dot(b);
        const double angle = std::acos(std::clamp(a.dot(b) / a.norm() / b.norm(), -1.0, 1.0)) * 180 / std::numbers::pi;
        smallest = std::min(smallest, angle);
        largest = std::max(largest, angle);
      }
    }
  }
  return {smallest, largest};
}

SurfaceMesh boundary(const TetMesh& mesh) {
  SurfaceMesh surface;
  surface.vertices = mesh.vertices;
  surface.triangles = boundary_triangles(mesh);
  return surface;
}

// Tets as sets of rounded corner positions, mapped by a symmetry of the cube.
std::set<std::array<std::array<long, 3>, 4>> as_set(const TetMesh& mesh, const Mat3& symmetry) {
  std::set<std::array<std::array<long, 3>, 4>> set;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    std::array<std::array<long, 3>, 4> tet{};
    const std::array<Vec3, 4> points = corners(mesh, t);
    for (int k = 0; k < 4; ++k)
      for (int i = 0; i < 3; ++i)
        tet[k][i] = std::lround((symmetry * points[k])[i] * 1e6);
    std::sort(tet.begin(), tet.end());
    set.insert(tet);
  }
  return set;
}

// The 48 signed permutations.
std::vector<Mat3> cube_symmetries() {
  std::vector<Mat3> all;
  std::array<int, 3> permutation = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Mat3 matrix = Mat3::Zero();
      for (int i = 0; i < 3; ++i)
        matrix(i, permutation[i]) = signs >> i & 1 ? -1 : 1;
      all.push_back(matrix);
    }
  } while (std::next_permutation(permutation.begin(), permutation.end()));
  return all;
}

// Part of the cube's 48 symmetries that map the mesh onto itself.
int symmetry_count(CellSplit split, int cells) {
  const Result<TetMesh> mesh = make_block_tets(box_block({1, 1, 1}), BlockCells{{cells, cells, cells}, split});
  const auto original = as_set(*mesh, Mat3::Identity());
  int count = 0;
  for (const Mat3& symmetry : cube_symmetries())
    count += as_set(*mesh, symmetry) == original;
  return count;
}

// Off-diagonal part of the sum of e e^T over all edges of all tets: 0 where no diagonal is favoured.
double edge_anisotropy(CellSplit split) {
  const Result<TetMesh> mesh = make_block_tets(box_block({1, 1, 1}), BlockCells{{4, 4, 4}, split});
  Mat3 moment = Mat3::Zero();
  for (Eigen::Index t = 0; t < mesh->tets.rows(); ++t) {
    const std::array<Vec3, 4> p = corners(*mesh, t);
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j)
        moment += (p[i] - p[j]).normalized() * (p[i] - p[j]).normalized().transpose();
  }
  return (std::abs(moment(0, 1)) + std::abs(moment(0, 2)) + std::abs(moment(1, 2))) / moment.trace();
}

TEST(StructuredTets, EverySplitFillsTheBoxAndConforms) {
  const int expected[] = {5, 6, 6, 6, 12, 24};
  for (std::size_t i = 0; i < std::size(SPLITS); ++i) {
    SCOPED_TRACE(i);
    const Result<TetMesh> mesh = make_block_tets(box_block({0.6, 0.8, 1.0}), BlockCells{{3, 4, 5}, SPLITS[i]});
    ASSERT_TRUE(mesh);
    EXPECT_EQ(mesh->tets.rows(), 60 * expected[i]);
    EXPECT_NEAR(total_volume(*mesh), 0.48, 1e-13);
    EXPECT_GT(smallest_volume(*mesh), 0.008 / 25);
    const SurfaceMesh surface = boundary(*mesh);
    const MeshReport report = inspect_mesh(surface);
    EXPECT_TRUE(report.is_closed());
    EXPECT_TRUE(report.is_manifold());
    EXPECT_TRUE(report.is_oriented());
    // A crack inside would add faces to the boundary.
    EXPECT_NEAR(report.area, 2 * (0.48 + 0.8 + 0.6), 1e-12);
    EXPECT_NEAR(report.volume, 0.48, 1e-13);
    std::vector<char> used(mesh->vertices.rows(), 0);
    for (Eigen::Index t = 0; t < mesh->tets.rows(); ++t)
      for (int k = 0; k < 4; ++k)
        used[mesh->tets(t, k)] = 1;
    EXPECT_EQ(std::count(used.begin(), used.end(), 0), 0);
  }
}

TEST(StructuredTets, OnlyThePlainKuhnSplitFavoursADirection) {
  EXPECT_GT(edge_anisotropy(CellSplit::kuhn), 0.1);
  for (const CellSplit split : SPLITS) {
    if (split == CellSplit::kuhn)
      continue;
    EXPECT_LT(edge_anisotropy(split), 1e-12) << static_cast<int>(split);
  }
}

TEST(StructuredTets, SymmetriesOfTheCubeAreKept) {
  EXPECT_EQ(symmetry_count(CellSplit::twenty_four, 3), 48);
  EXPECT_EQ(symmetry_count(CellSplit::twenty_four, 4), 48);
  EXPECT_EQ(symmetry_count(CellSplit::kuhn_outward, 4), 48);
  EXPECT_EQ(symmetry_count(CellSplit::kuhn_mirrored, 4), 48);
  EXPECT_EQ(symmetry_count(CellSplit::five, 4), 48);
  EXPECT_EQ(symmetry_count(CellSplit::five, 3), 24); // an odd number of cells has no mirror
  EXPECT_EQ(symmetry_count(CellSplit::kuhn, 4), 12);
}

TEST(StructuredTets, RoundRodConvergesToTheCylinder) {
  for (const Axis axis : {Axis::x, Axis::y, Axis::z}) {
    double previous = 0;
    for (const int n : {4, 8, 16}) {
      BlockCells cells{{n, n, n}, CellSplit::kuhn_outward};
      const Result<TetMesh> mesh = make_block_tets(cylinder_block(1.0, 2.0, axis), cells);
      ASSERT_TRUE(mesh);
      EXPECT_GT(smallest_volume(*mesh), 0);
      // The section is the regular polygon with 4n corners.
      const double polygon = 0.5 * 4 * n * std::sin(2 * std::numbers::pi / (4 * n));
      EXPECT_NEAR(total_volume(*mesh), 2 * polygon, 1e-12);
      const double error = std::abs(total_volume(*mesh) - 2 * std::numbers::pi);
      if (previous > 0) {
        EXPECT_NEAR(error / previous, 0.25, 0.02);
      }
      previous = error;
    }
  }
}

TEST(StructuredTets, RoundSectionsCutOutwardsHaveGoodAngles) {
  const Block rod = rod_block(1.0, 0.2, 0.2, Section::round, Axis::z);
  const Result<TetMesh> outward = make_block_tets(rod, 0.02);
  ASSERT_TRUE(outward);
  const auto [smallest, largest] = dihedral_range(*outward);
  EXPECT_GT(smallest, 25);
  EXPECT_LT(largest, 140);
  // The reason for the outward split: others leave nearly flat tets in the four corner columns.
  const Result<TetMesh> five = make_block_tets(rod, BlockCells{{10, 10, 50}, CellSplit::five});
  EXPECT_GT(dihedral_range(*five).second, 165);
}

TEST(StructuredTets, BoxAnglesAreThoseOfTheSplit) {
  const auto range = [](CellSplit split) {
    return dihedral_range(*make_block_tets(box_block({1, 1, 1}), BlockCells{{2, 2, 2}, split}));
  };
  EXPECT_NEAR(range(CellSplit::kuhn).first, 45, 1e-9);
  EXPECT_NEAR(range(CellSplit::kuhn).second, 90, 1e-9);
  EXPECT_NEAR(range(CellSplit::five).first, std::acos(1 / std::sqrt(3.0)) * 180 / std::numbers::pi, 1e-9);
  EXPECT_NEAR(range(CellSplit::twelve).second, 120, 1e-9);
}

TEST(StructuredTets, BodyCoordinatesRunFromZeroToOne) {
  const Result<TetMesh> rod = make_block_tets(rod_block(2.0, 0.1, 0.1, Section::round), 0.05);
  ASSERT_TRUE(rod);
  ASSERT_EQ(rod->body_coordinates.rows(), rod->vertices.rows());
  for (Eigen::Index i = 0; i < rod->vertices.rows(); ++i) {
    EXPECT_NEAR(rod->body_coordinates(i, 0), rod->vertices(i, 0) / 2.0 + 0.5, 1e-14);
    EXPECT_NEAR(rod->body_coordinates(i, 1), rod->vertices(i, 2) / 0.1 + 0.5, 1e-14);
  }
  const Result<TetMesh> sheet = make_block_tets(sheet_block(1.0, 0.5, 0.01), BlockCells{{8, 2, 4}, CellSplit::five});
  ASSERT_TRUE(sheet);
  EXPECT_EQ(sheet->body_coordinates.col(0).minCoeff(), 0);
  EXPECT_EQ(sheet->body_coordinates.col(1).maxCoeff(), 1);
}

TEST(StructuredTets, TargetEdgeGivesTheCells) {
  const Result<std::array<int, 3>> cells = cells_for_edge(box_block({0.6, 0.05, 0.05}), 0.05 / 3);
  ASSERT_TRUE(cells);
  EXPECT_EQ(*cells, (std::array<int, 3>{36, 3, 3}));
  const Result<std::array<int, 3>> round = cells_for_edge(cylinder_block(0.05, 1.0), 0.04);
  ASSERT_TRUE(round);
  EXPECT_EQ(*round, (std::array<int, 3>{4, 25, 4}));
}

TEST(StructuredTets, BadCountsAreErrors) {
  EXPECT_EQ(make_block_tets(box_block({1, 1, 1}), BlockCells{{0, 1, 1}, CellSplit::five}).error().code,
            ErrorCode::bad_input);
  EXPECT_FALSE(make_block_tets(box_block({1, 0, 1}), BlockCells{{1, 1, 1}, CellSplit::five}));
  EXPECT_FALSE(make_block_tets(box_block({1, 1, 1}), BlockCells{{100000, 100000, 1}, CellSplit::five}));
  EXPECT_FALSE(make_block_tets(cylinder_block(1, 1), BlockCells{{3, 3, 3}, CellSplit::kuhn_outward}));
  EXPECT_FALSE(make_block_tets(cylinder_block(1, 1), BlockCells{{4, 3, 2}, CellSplit::kuhn_outward}));
}

} // namespace
} // namespace wry::geometry
