#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include <Eigen/Geometry>

#include "sim/geometry/isosurface_stuffing.h"

namespace wry::geometry {

namespace {

constexpr int MAX_ROUNDS = 50;
/// Pieces below this share of the volume are crumbs.
constexpr double CRUMB = .001;
constexpr int FACES[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

std::size_t at(Eigen::Index i) {
  return static_cast<std::size_t>(i);
}

std::size_t find_root(std::vector<std::size_t>& parent, std::size_t i) {
  while (parent[i] != i)
    i = parent[i] = parent[parent[i]];
  return i;
}

/// Keeps the tets that are marked, and the vertices they use, in order.
void keep_marked(TetMesh& mesh, const std::vector<char>& keep) {
  std::vector<std::int32_t> index(at(mesh.vertices.rows()), -1);
  for (std::size_t t = 0; t < keep.size(); ++t)
    if (keep[t])
      for (int k = 0; k < 4; ++k)
        index[at(mesh.tets(static_cast<Eigen::Index>(t), k))] = 0;
  std::int32_t count = 0;
  for (std::int32_t& entry : index)
    if (entry == 0)
      entry = count++;
  TetMesh kept;
  kept.vertices.resize(count, 3);
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    if (index[at(v)] >= 0)
      kept.vertices.row(index[at(v)]) = mesh.vertices.row(v);
  kept.tets.resize(std::count(keep.begin(), keep.end(), 1), 4);
  Eigen::Index row = 0;
  for (std::size_t t = 0; t < keep.size(); ++t) {
    if (!keep[t])
      continue;
    for (int k = 0; k < 4; ++k)
      kept.tets(row, k) = index[at(mesh.tets(static_cast<Eigen::Index>(t), k))];
    ++row;
  }
  mesh = std::move(kept);
}

bool holds(const TetMesh& mesh, std::size_t tet, std::int32_t vertex) {
  return (mesh.tets.row(static_cast<Eigen::Index>(tet)).array() == vertex).any();
}

/// Vertices at which the boundary is not one fan, and the ends of edges with more than two boundary triangles.
struct Pinches {
  std::vector<std::array<std::int32_t, 2>> edges;
  std::vector<std::int32_t> vertices;
};

Pinches find_pinches(const TetMesh& mesh) {
  const Triangles boundary = boundary_triangles(mesh);
  struct Side {
    std::array<std::int32_t, 2> ends;
    std::size_t corner_low, corner_high;
  };
  std::vector<Side> sides;
  std::vector<std::size_t> parent(at(boundary.size()));
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  for (std::size_t i = 0; i < parent.size(); ++i) {
    const std::size_t next = i / 3 * 3 + (i + 1) % 3;
    const std::int32_t a = boundary.data()[i];
    const std::int32_t b = boundary.data()[next];
    sides.push_back(a < b ? Side{{a, b}, i, next} : Side{{b, a}, next, i});
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.ends != b.ends ? a.ends < b.ends : a.corner_low < b.corner_low;
  });
  Pinches pinches;
  for (std::size_t begin = 0; begin < sides.size();) {
    std::size_t end = begin + 1;
    for (; end < sides.size() && sides[end].ends == sides[begin].ends; ++end) {
      parent[find_root(parent, sides[end].corner_low)] = find_root(parent, sides[begin].corner_low);
      parent[find_root(parent, sides[end].corner_high)] = find_root(parent, sides[begin].corner_high);
    }
    if (end - begin > 2)
      pinches.edges.push_back(sides[begin].ends);
    begin = end;
  }
  std::vector<int> fans(at(mesh.vertices.rows()), 0);
  for (std::size_t i = 0; i < parent.size(); ++i)
    if (find_root(parent, i) == i && ++fans[at(boundary.data()[i])] == 2)
      pinches.vertices.push_back(boundary.data()[i]);
  std::sort(pinches.vertices.begin(), pinches.vertices.end());
  return pinches;
}

/// Marks for removal all but the largest group of `star` tets that hang together through faces which hold every vertex
/// of `centre`. A star that is one group around its centre goes as a whole.
void drop_smaller_groups(const TetMesh& mesh, const std::vector<std::size_t>& star,
                         const std::vector<std::int32_t>& centre, std::vector<char>& keep) {
  std::vector<std::size_t> parent(star.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto shares_face = [&](std::size_t a, std::size_t b) {
    int shared = 0;
    for (int k = 0; k < 4; ++k)
      shared += holds(mesh, a, mesh.tets(static_cast<Eigen::Index>(b), k)) ? 1 : 0;
    return shared == 3;
  };
  for (std::size_t i = 0; i < star.size(); ++i)
    for (std::size_t j = i + 1; j < star.size(); ++j)
      if (shares_face(star[i], star[j]) && std::all_of(centre.begin(), centre.end(), [&](std::int32_t v) {
            return holds(mesh, star[i], v) && holds(mesh, star[j], v);
          }))
        parent[find_root(parent, j)] = find_root(parent, i);
  std::vector<double> volume(star.size(), 0.0);
  for (std::size_t i = 0; i < star.size(); ++i)
    volume[find_root(parent, i)] += tet_volume(mesh, static_cast<Eigen::Index>(star[i]));
  const std::size_t largest = static_cast<std::size_t>(std::max_element(volume.begin(), volume.end()) - volume.begin());
  const bool one_group = std::count_if(volume.begin(), volume.end(), [](double v) { return v != 0; }) == 1;
  for (std::size_t i = 0; i < star.size(); ++i)
    if (one_group || find_root(parent, i) != largest)
      keep[star[i]] = 0;
}

std::int64_t remove_pinches(TetMesh& mesh) {
  const Pinches pinches = find_pinches(mesh);
  if (pinches.edges.empty() && pinches.vertices.empty())
    return 0;
  std::vector<std::vector<std::size_t>> tets_of(at(mesh.vertices.rows()));
  for (std::size_t t = 0; t < at(mesh.tets.rows()); ++t)
    for (int k = 0; k < 4; ++k)
      tets_of[at(mesh.tets(static_cast<Eigen::Index>(t), k))].push_back(t);
  std::vector<char> keep(at(mesh.tets.rows()), 1);
  for (const auto& edge : pinches.edges) {
    std::vector<std::size_t> star;
    for (const std::size_t t : tets_of[at(edge[0])])
      if (holds(mesh, t, edge[1]))
        star.push_back(t);
    drop_smaller_groups(mesh, star, {edge[0], edge[1]}, keep);
  }
  if (pinches.edges.empty())
    for (const std::int32_t vertex : pinches.vertices)
      drop_smaller_groups(mesh, tets_of[at(vertex)], {vertex}, keep);
  const std::int64_t removed = std::count(keep.begin(), keep.end(), 0);
  keep_marked(mesh, keep);
  return removed;
}

std::int64_t remove_crumbs(TetMesh& mesh) {
  struct Face {
    std::array<std::int32_t, 3> key;
    std::size_t tet;
  };
  std::vector<Face> faces;
  std::vector<std::size_t> parent(at(mesh.tets.rows()));
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  for (std::size_t t = 0; t < parent.size(); ++t) {
    for (const auto& face : FACES) {
      std::array<std::int32_t, 3> key{};
      for (int k = 0; k < 3; ++k)
        key[k] = mesh.tets(static_cast<Eigen::Index>(t), face[k]);
      std::sort(key.begin(), key.end());
      faces.push_back({key, t});
    }
  }
  std::sort(faces.begin(), faces.end(),
            [](const Face& a, const Face& b) { return a.key != b.key ? a.key < b.key : a.tet < b.tet; });
  for (std::size_t i = 1; i < faces.size(); ++i)
    if (faces[i].key == faces[i - 1].key)
      parent[find_root(parent, faces[i].tet)] = find_root(parent, faces[i - 1].tet);
  std::vector<double> volume(parent.size(), 0.0);
  double total = 0;
  for (std::size_t t = 0; t < parent.size(); ++t) {
    volume[find_root(parent, t)] += tet_volume(mesh, static_cast<Eigen::Index>(t));
    total += tet_volume(mesh, static_cast<Eigen::Index>(t));
  }
  std::vector<char> keep(parent.size(), 1);
  for (std::size_t t = 0; t < parent.size(); ++t)
    keep[t] = volume[find_root(parent, t)] >= CRUMB * total ? 1 : 0;
  const std::int64_t removed = std::count(keep.begin(), keep.end(), 0);
  if (removed > 0 || mesh.vertices.rows() > 0)
    keep_marked(mesh, keep);
  return removed;
}

} // namespace

std::int64_t remove_pinches_and_crumbs(TetMesh& mesh) {
  std::int64_t removed = 0;
  for (int round = 0; round < MAX_ROUNDS; ++round) {
    const std::int64_t now = remove_pinches(mesh);
    removed += now;
    if (now == 0)
      break;
  }
  return removed + remove_crumbs(mesh);
}

} // namespace wry::geometry
