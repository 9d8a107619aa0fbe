#include "sim/geometry/structured_tets.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace wry::geometry {

namespace {

using Lattice = std::array<int, 3>;

// Corners of a cell are numbered by bits: 1 for x, 2 for y, 4 for z.
using CornerTet = std::array<int, 4>;

constexpr std::array<CornerTet, 5> FIVE = {{{0, 3, 5, 6}, {1, 0, 3, 5}, {2, 0, 3, 6}, {4, 0, 5, 6}, {7, 3, 5, 6}}};
// Paths from corner 0 to corner 7 along the axes, one per permutation.
constexpr std::array<CornerTet, 6> KUHN = {
    {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}}};

int tets_per_cell(CellSplit split) {
  switch (split) {
  case CellSplit::five:
    return 5;
  case CellSplit::twelve:
    return 12;
  case CellSplit::twenty_four:
    return 24;
  default:
    return 6;
  }
}

Status check(const Block& block, const BlockCells& settings) {
  double count = tets_per_cell(settings.split);
  for (int i = 0; i < 3; ++i) {
    if (!(block.size[i] > 0) || !std::isfinite(block.size[i]))
      return make_error(ErrorCode::bad_input, "a block needs positive, finite sizes; along {} it is {} m", "xyz"[i],
                        block.size[i]);
    if (settings.cells[i] < 1)
      return make_error(ErrorCode::bad_input, "a block needs at least one cell along each axis; along {} it has {}",
                        "xyz"[i], settings.cells[i]);
    count *= settings.cells[i];
  }
  constexpr double MAX_TETS = 1e8;
  if (count > MAX_TETS)
    return make_error(ErrorCode::bad_input,
                      "{} x {} x {} cells make {:.3g} tets; the limit is {:.0e}: use a longer edge", settings.cells[0],
                      settings.cells[1], settings.cells[2], count, MAX_TETS);
  if (block.section == Section::round) {
    const int first = settings.cells[axis_index(next_axis(block.axis))];
    const int second = settings.cells[axis_index(next_axis(next_axis(block.axis)))];
    if (first != second || first % 2 != 0)
      return make_error(ErrorCode::bad_input,
                        "a round section needs the same even number of cells both ways across; it has {} and {}", first,
                        second);
  }
  return {};
}

// Cuts cells one by one; positions live in lattice coordinates until the end.
class Cutter {
public:
  Cutter(const Block& block, const BlockCells& settings)
      : m_block(block)
      , m_cells(settings.cells)
      , m_split(settings.split) {}

  TetMesh cut() {
    for (int k = 0; k <= m_cells[2]; ++k)
      for (int j = 0; j <= m_cells[1]; ++j)
        for (int i = 0; i <= m_cells[0]; ++i)
          m_points.emplace_back(i, j, k);
    if (m_split == CellSplit::twenty_four)
      add_face_centres();
    const std::size_t cells = 1ULL * m_cells[0] * m_cells[1] * m_cells[2];
    m_tets.reserve(cells * tets_per_cell(m_split));
    for (int k = 0; k < m_cells[2]; ++k)
      for (int j = 0; j < m_cells[1]; ++j)
        for (int i = 0; i < m_cells[0]; ++i)
          cut_cell({i, j, k});
    return finish();
  }

private:
  std::int32_t lattice_index(const Lattice& at) const {
    return at[0] + (m_cells[0] + 1) * (at[1] + (m_cells[1] + 1) * at[2]);
  }

  std::int32_t corner(const Lattice& cell, int bits) const {
    return lattice_index({cell[0] + (bits & 1), cell[1] + (bits >> 1 & 1), cell[2] + (bits >> 2 & 1)});
  }

  void add_face_centres() {
    for (int normal = 0; normal < 3; ++normal) {
      m_first_face[normal] = static_cast<std::int32_t>(m_points.size());
      Lattice last = {m_cells[0] - 1, m_cells[1] - 1, m_cells[2] - 1};
      ++last[normal];
      for (int k = 0; k <= last[2]; ++k) {
        for (int j = 0; j <= last[1]; ++j) {
          for (int i = 0; i <= last[0]; ++i) {
            Vec3 centre(i + 0.5, j + 0.5, k + 0.5);
            centre[normal] -= 0.5;
            m_points.push_back(centre);
          }
        }
      }
    }
  }

  std::int32_t face_centre(Lattice cell, int normal, int side) const {
    Lattice counts = m_cells;
    ++counts[normal];
    cell[normal] += side;
    return m_first_face[normal] + cell[0] + counts[0] * (cell[1] + counts[1] * cell[2]);
  }

  // Which axes to mirror in this cell, as bits.
  int mirror(const Lattice& cell) const {
    int bits = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const bool along = m_block.section == Section::round && axis == axis_index(m_block.axis);
      const bool odd = cell[axis] % 2 != 0;
      const bool before_middle = 2 * cell[axis] + 1 < m_cells[axis];
      if (m_split == CellSplit::kuhn_mirrored || (m_split == CellSplit::kuhn_outward && along))
        bits |= odd ? 1 << axis : 0;
      else if (m_split == CellSplit::kuhn_outward)
        bits |= before_middle ? 1 << axis : 0;
      else if (m_split == CellSplit::five)
        bits ^= odd ? 1 : 0;
    }
    return bits;
  }

  void cut_cell(const Lattice& cell) {
    if (m_split == CellSplit::twelve || m_split == CellSplit::twenty_four)
      return cut_from_centre(cell);
    const int bits = mirror(cell);
    const auto add = [&](const CornerTet& tet) {
      add_tet({corner(cell, tet[0] ^ bits), corner(cell, tet[1] ^ bits), corner(cell, tet[2] ^ bits),
               corner(cell, tet[3] ^ bits)});
    };
    if (m_split == CellSplit::five)
      std::for_each(FIVE.begin(), FIVE.end(), add);
    else
      std::for_each(KUHN.begin(), KUHN.end(), add);
  }

  void cut_from_centre(const Lattice& cell) {
    const auto centre = static_cast<std::int32_t>(m_points.size());
    m_points.emplace_back(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5);
    for (int normal = 0; normal < 3; ++normal) {
      for (int side = 0; side < 2; ++side) {
        const int base = side << normal;
        const int first = 1 << (normal + 1) % 3;
        const int second = 1 << (normal + 2) % 3;
        const std::array<std::int32_t, 4> ring = {corner(cell, base), corner(cell, base | first),
                                                  corner(cell, base | first | second), corner(cell, base | second)};
        if (m_split == CellSplit::twenty_four) {
          for (int i = 0; i < 4; ++i)
            add_tet({centre, face_centre(cell, normal, side), ring[i], ring[(i + 1) % 4]});
        } else {
          // The diagonal joins corners of even sum: the same from both cells of a face, and it alternates from face to
          // face.
          const int shift = (cell[0] + cell[1] + cell[2] + side) % 2;
          add_tet({centre, ring[shift], ring[shift + 1], ring[shift + 2]});
          add_tet({centre, ring[shift], ring[shift + 2], ring[(shift + 3) % 4]});
        }
      }
    }
  }

  void add_tet(std::array<std::int32_t, 4> tet) {
    const Vec3& origin = m_points[tet[0]];
    const Vec3 a = m_points[tet[1]] - origin;
    const Vec3 b = m_points[tet[2]] - origin;
    const Vec3 c = m_points[tet[3]] - origin;
    if (a.cross(b).dot(c) < 0)
      std::swap(tet[2], tet[3]);
    m_tets.push_back(tet);
  }

  TetMesh finish() const {
    TetMesh mesh;
    const auto count = static_cast<Eigen::Index>(m_points.size());
    mesh.vertices.resize(count, 3);
    mesh.body_coordinates.resize(count, 2);
    const Vec3 cells(m_cells[0], m_cells[1], m_cells[2]);
    const int u = axis_index(m_block.u_axis);
    const int v = axis_index(m_block.v_axis);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Vec3 point = block_point(m_block, m_points[static_cast<std::size_t>(i)].cwiseQuotient(cells));
      mesh.vertices.row(i) = point.transpose();
      mesh.body_coordinates(i, 0) = std::clamp(point[u] / m_block.size[u] + 0.5, 0.0, 1.0);
      mesh.body_coordinates(i, 1) = std::clamp(point[v] / m_block.size[v] + 0.5, 0.0, 1.0);
    }
    mesh.tets.resize(static_cast<Eigen::Index>(m_tets.size()), 4);
    for (std::size_t i = 0; i < m_tets.size(); ++i)
      for (int k = 0; k < 4; ++k)
        mesh.tets(static_cast<Eigen::Index>(i), k) = m_tets[i][k];
    return mesh;
  }

  const Block& m_block;
  Lattice m_cells;
  CellSplit m_split;
  std::array<std::int32_t, 3> m_first_face{};
  std::vector<Vec3> m_points;
  std::vector<std::array<std::int32_t, 4>> m_tets;
};

Status check_positive_volumes(const TetMesh& mesh) {
  for (Eigen::Index i = 0; i < mesh.tets.rows(); ++i) {
    const Vec3 origin = mesh.vertices.row(mesh.tets(i, 0)).transpose();
    const Vec3 a = mesh.vertices.row(mesh.tets(i, 1)).transpose() - origin;
    const Vec3 b = mesh.vertices.row(mesh.tets(i, 2)).transpose() - origin;
    const Vec3 c = mesh.vertices.row(mesh.tets(i, 3)).transpose() - origin;
    if (!(a.cross(b).dot(c) > 0))
      return make_error(ErrorCode::bad_input, "tet {} of a block has volume {} m^3: its sizes are too unequal to mesh",
                        i, a.cross(b).dot(c) / 6);
  }
  return {};
}

} // namespace

CellSplit default_split(Section section) {
  return section == Section::round ? CellSplit::kuhn_outward : CellSplit::five;
}

Result<TetMesh> make_block_tets(const Block& block, const BlockCells& cells) {
  if (Status status = check(block, cells); !status)
    return status.error();
  TetMesh mesh = Cutter(block, cells).cut();
  if (Status status = check_positive_volumes(mesh); !status)
    return status.error();
  return mesh;
}

Result<TetMesh> make_block_tets(const Block& block, double target_edge) {
  Result<std::array<int, 3>> cells = cells_for_edge(block, target_edge);
  if (!cells)
    return std::move(cells).error();
  return make_block_tets(block, BlockCells{*cells, default_split(block.section)});
}

} // namespace wry::geometry
