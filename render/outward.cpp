#include "render/outward.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

namespace wry::render {
namespace {

/// Per vertex the first of those at the same place, to a ten-millionth of the whole: files round what they share.
std::vector<std::int32_t> places_of(const Points& exact) {
  const Vec3 low = exact.colwise().minCoeff();
  const double step = 1e-7 * std::max((exact.colwise().maxCoeff().transpose() - low).maxCoeff(), 1e-300);
  const Points x = (exact / step).array().round();
  std::vector<std::int32_t> order(static_cast<std::size_t>(x.rows()));
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](std::int32_t i) { return std::tuple(x(i, 0), x(i, 1), x(i, 2)); };
  std::sort(order.begin(), order.end(),
            [&](std::int32_t a, std::int32_t b) { return std::pair(key(a), a) < std::pair(key(b), b); });
  std::vector<std::int32_t> places(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    places[static_cast<std::size_t>(order[i])] = same ? places[static_cast<std::size_t>(order[i - 1])] : order[i];
  }
  return places;
}

/// Joins vertices to connected pieces.
class Pieces {
public:
  explicit Pieces(std::size_t count)
      : m_parents(count) {
    std::iota(m_parents.begin(), m_parents.end(), 0);
  }
  std::int32_t piece_of(std::int32_t vertex) {
    std::int32_t& parent = m_parents[static_cast<std::size_t>(vertex)];
    if (parent != vertex)
      parent = piece_of(parent);
    return parent;
  }
  void join(std::int32_t a, std::int32_t b) {
    const std::int32_t of_b = piece_of(b);
    m_parents[static_cast<std::size_t>(piece_of(a))] = of_b;
  }

private:
  std::vector<std::int32_t> m_parents;
};

} // namespace

bool is_closed_outward(const SceneBody& body) {
  if (body.triangles.rows() == 0 || !body.rest_positions.allFinite())
    return false;
  const std::vector<std::int32_t> places = places_of(body.rest_positions);
  const auto corner = [&](Eigen::Index t, int c) { return places[static_cast<std::size_t>(body.triangles(t, c % 3))]; };
  std::vector<std::pair<std::int32_t, std::int32_t>> forth, back;
  Pieces pieces(places.size());
  for (Eigen::Index t = 0; t < body.triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c) {
      forth.emplace_back(corner(t, c), corner(t, c + 1));
      back.emplace_back(corner(t, c + 1), corner(t, c));
    }
    pieces.join(corner(t, 0), corner(t, 1));
    pieces.join(corner(t, 1), corner(t, 2));
  }
  std::sort(forth.begin(), forth.end());
  std::sort(back.begin(), back.end());
  if (forth != back)
    return false;
  std::map<std::int32_t, double> volumes;
  for (Eigen::Index t = 0; t < body.triangles.rows(); ++t) {
    const auto x = [&](int c) { return Vec3(body.rest_positions.row(corner(t, c)).transpose()); };
    const std::int32_t piece = body.tets.rows() > 0 ? 0 : pieces.piece_of(corner(t, 0));
    volumes[piece] += x(0).dot(x(1).cross(x(2)));
  }
  return std::all_of(volumes.begin(), volumes.end(), [](const auto& piece) { return piece.second > 0.0; });
}

bool is_right_way_out(const SceneBody& body, const FrameBody& on_frame, const Eigen::Ref<const Points>& positions) {
  if (body.tets.rows() == 0)
    return !body.simulated && on_frame.transform.topLeftCorner<3, 3>().determinant() > 0.0;
  for (Eigen::Index t = 0; t < body.tets.rows(); ++t) {
    const Vec3 origin = positions.row(body.tets(t, 0)).transpose();
    const auto edge = [&](int c) { return Vec3(positions.row(body.tets(t, c)).transpose() - origin); };
    if (!(edge(1).cross(edge(2)).dot(edge(3)) > 0.0))
      return false;
  }
  return true;
}

} // namespace wry::render
