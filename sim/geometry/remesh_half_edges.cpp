#include "sim/geometry/remesh_half_edges.h"

#include <algorithm>
#include <array>

#include <Eigen/Geometry>

namespace wry::geometry {

namespace {

struct Directed {
  int low, high, half_edge;
  bool forward;
};

Error edge_error(const Points& vertices, int a, int b, const std::string& finding) {
  return make_error(
      ErrorCode::bad_input,
      "the surface {} at the edge from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g}) m; it must be "
      "closed, with two triangles at every edge. Close the hole or remove the extra faces.",
      finding, vertices(a, 0), vertices(a, 1), vertices(a, 2), vertices(b, 0), vertices(b, 1), vertices(b, 2));
}

} // namespace

Result<HalfEdgeMesh> HalfEdgeMesh::from_surface(const SurfaceMesh& surface) {
  if (surface.triangles.rows() == 0)
    return make_error(ErrorCode::bad_input, "the surface has no triangles");
  HalfEdgeMesh mesh;
  for (Eigen::Index i = 0; i < surface.vertices.rows(); ++i)
    mesh.m_points.push_back(surface.vertices.row(i).transpose());
  mesh.m_out.assign(mesh.m_points.size(), -1);
  std::vector<Directed> edges;
  for (int h = 0; h < surface.triangles.size(); ++h) {
    const int a = surface.triangles.data()[h];
    const int b = surface.triangles.data()[next(h)];
    mesh.m_origin.push_back(a);
    mesh.m_out[at(a)] = h;
    edges.push_back({std::min(a, b), std::max(a, b), h, a < b});
  }
  mesh.m_twin.assign(mesh.m_origin.size(), -1);
  mesh.m_feature.assign(mesh.m_origin.size(), 0);
  std::sort(edges.begin(), edges.end(), [](const Directed& p, const Directed& q) {
    return std::array{p.low, p.high, p.half_edge} < std::array{q.low, q.high, q.half_edge};
  });
  for (std::size_t begin = 0; begin < edges.size();) {
    std::size_t end = begin;
    while (end < edges.size() && edges[end].low == edges[begin].low && edges[end].high == edges[begin].high)
      ++end;
    const Directed& first = edges[begin];
    if (end - begin == 1)
      return edge_error(surface.vertices, first.low, first.high, "is open");
    if (end - begin > 2)
      return edge_error(surface.vertices, first.low, first.high, fmt::format("has {} triangles", end - begin));
    if (first.forward == edges[begin + 1].forward)
      return edge_error(surface.vertices, first.low, first.high, "has two triangles that face opposite ways");
    mesh.connect(first.half_edge, edges[begin + 1].half_edge);
    begin = end;
  }
  std::vector<int> uses(mesh.m_points.size(), 0);
  for (const int origin : mesh.m_origin)
    ++uses[at(origin)];
  for (int v = 0; v < mesh.vertices(); ++v) {
    if (mesh.m_out[at(v)] >= 0 && mesh.valence(v) != uses[at(v)])
      return make_error(ErrorCode::bad_input,
                        "the surface touches itself in the point ({:.4g}, {:.4g}, {:.4g}) m; separate "
                        "the parts there",
                        mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z());
  }
  return mesh;
}

int HalfEdgeMesh::valence(int vertex) const {
  int count = 0;
  int h = out(vertex);
  do {
    ++count;
    h = around(h);
  } while (h != out(vertex));
  return count;
}

Vec3 HalfEdgeMesh::normal(int t) const {
  const Vec3& a = point(m_origin[at(3 * t)]);
  return (point(m_origin[at(3 * t + 1)]) - a).cross(point(m_origin[at(3 * t + 2)]) - a);
}

int HalfEdgeMesh::add_triangle(int a, int b, int c) {
  const int h = half_edges();
  for (const int v : {a, b, c}) {
    m_origin.push_back(v);
    m_twin.push_back(-1);
    m_feature.push_back(0);
  }
  return h;
}

int HalfEdgeMesh::split(int h, const Vec3& position) {
  const int t = twin(h);
  const int b = to(h);
  const int a = from(h);
  const int c = apex(h);
  const int d = apex(t);
  const int m = vertices();
  m_points.push_back(position);
  m_out.push_back(-1);
  // a b c becomes a m c and m b c; b a d becomes b m d and m a d.
  const int bc_twin = twin(next(h));
  const int ad_twin = twin(next(t));
  const char bc_feature = m_feature[at(next(h))];
  const char ad_feature = m_feature[at(next(t))];
  const char feature = m_feature[at(h)];
  const int n = add_triangle(m, b, c);
  const int o = add_triangle(m, a, d);
  m_origin[at(next(h))] = m;
  m_origin[at(next(t))] = m;
  connect(h, o);
  connect(t, n);
  connect(next(n), bc_twin);
  connect(next(o), ad_twin);
  connect(next(h), previous(n));
  connect(next(t), previous(o));
  for (const int half : {h, t, n, o})
    m_feature[at(half)] = feature;
  m_feature[at(next(n))] = bc_feature;
  m_feature[at(next(o))] = ad_feature;
  m_feature[at(next(h))] = m_feature[at(next(t))] = 0;
  m_out[at(m)] = n;
  m_out[at(a)] = h;
  m_out[at(b)] = t;
  m_out[at(c)] = previous(h);
  m_out[at(d)] = previous(t);
  return m;
}

bool HalfEdgeMesh::flip(int h) {
  const int t = twin(h);
  const int a = from(h);
  const int b = to(h);
  const int c = apex(h);
  const int d = apex(t);
  if (c == d || valence(a) <= 3 || valence(b) <= 3)
    return false;
  int k = out(c);
  do {
    if (to(k) == d)
      return false;
    k = around(k);
  } while (k != out(c));
  const int bc = next(h);
  const int ca = previous(h);
  const int ad = next(t);
  const int db = previous(t);
  const std::array<int, 4> twins{twin(bc), twin(ca), twin(ad), twin(db)};
  const std::array<char, 4> features{m_feature[at(bc)], m_feature[at(ca)], m_feature[at(ad)], m_feature[at(db)]};
  // Triangle of h becomes (d, c, a), that of t becomes (c, d, b).
  m_origin[at(h)] = d;
  m_origin[at(bc)] = c;
  m_origin[at(ca)] = a;
  m_origin[at(t)] = c;
  m_origin[at(ad)] = d;
  m_origin[at(db)] = b;
  connect(h, t);
  connect(bc, twins[1]); // c a
  connect(ca, twins[2]); // a d
  connect(ad, twins[3]); // d b
  connect(db, twins[0]); // b c
  m_feature[at(bc)] = features[1];
  m_feature[at(ca)] = features[2];
  m_feature[at(ad)] = features[3];
  m_feature[at(db)] = features[0];
  m_out[at(a)] = ca;
  m_out[at(b)] = db;
  m_out[at(c)] = t;
  m_out[at(d)] = h;
  return true;
}

bool HalfEdgeMesh::can_collapse(int h) const {
  const int t = twin(h);
  const int a = from(h);
  const int b = to(h);
  const int c = apex(h);
  const int d = apex(t);
  if (c == d || valence(c) <= 3 || valence(d) <= 3)
    return false;
  int common = 0;
  int k = out(a);
  do {
    int l = out(b);
    do {
      common += to(l) == to(k) ? 1 : 0;
      l = around(l);
    } while (l != out(b));
    k = around(k);
  } while (k != out(a));
  return common == 2;
}

void HalfEdgeMesh::collapse(int h) {
  const int t = twin(h);
  const int a = from(h);
  const int b = to(h);
  const int c = apex(h);
  const int d = apex(t);
  int k = h;
  do {
    const int following = around(k);
    m_origin[at(k)] = b;
    k = following;
  } while (k != h);
  const int bc = twin(next(h));     // c -> b
  const int ca = twin(previous(h)); // a -> c
  const int ad = twin(next(t));     // d -> a
  const int db = twin(previous(t)); // b -> d
  const bool c_feature = is_feature(next(h)) || is_feature(previous(h));
  const bool d_feature = is_feature(next(t)) || is_feature(previous(t));
  connect(bc, ca);
  connect(ad, db);
  m_feature[at(bc)] = m_feature[at(ca)] = c_feature ? 1 : 0;
  m_feature[at(ad)] = m_feature[at(db)] = d_feature ? 1 : 0;
  m_out[at(a)] = -1;
  m_out[at(b)] = ca;
  m_out[at(c)] = bc;
  m_out[at(d)] = ad;
  for (const int base : {h - h % 3, t - t % 3})
    for (int i = 0; i < 3; ++i)
      m_origin[at(base + i)] = m_twin[at(base + i)] = -1;
}

SurfaceMesh HalfEdgeMesh::to_surface() const {
  std::vector<int> index(m_points.size(), -1);
  int count = 0;
  for (int v = 0; v < vertices(); ++v)
    index[at(v)] = is_vertex_alive(v) ? count++ : -1;
  SurfaceMesh mesh;
  mesh.vertices.resize(count, 3);
  for (int v = 0; v < vertices(); ++v)
    if (index[at(v)] >= 0)
      mesh.vertices.row(index[at(v)]) = point(v).transpose();
  int triangles = 0;
  for (int h = 0; h < half_edges(); h += 3)
    triangles += is_alive(h) ? 1 : 0;
  mesh.triangles.resize(triangles, 3);
  int row = 0;
  for (int h = 0; h < half_edges(); h += 3) {
    if (!is_alive(h))
      continue;
    for (int k = 0; k < 3; ++k)
      mesh.triangles(row, k) = index[at(m_origin[at(h + k)])];
    ++row;
  }
  return mesh;
}

} // namespace wry::geometry
