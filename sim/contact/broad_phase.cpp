#include "sim/contact/broad_phase.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "sim/contact/distance.h"
#include "sim/contact/pair_boxes.h"

namespace wry::contact {

namespace {

constexpr std::size_t GRAIN = 128;
/// Rooms go on beyond the end of a way by this many times as much, where the next steps go, at most by so many margins.
constexpr double STEPS_AHEAD = 2.0;
constexpr double AHEAD = 2.0;
/// Ways longer than so many margins are long.
constexpr double LONG_WAY = 4.0;
/// Lists for ways longer than so many margins are made anew for short ways: looking through them takes longer.
constexpr double TOO_LONG_WAY = 16.0;
/// Half the side of small boxes, as a share of the distance.
constexpr double SMALL_ROOM = 0.25;
constexpr std::size_t PICK_GRAIN = 2048;
/// Numbers that are kept in single precision are moved by this share to the safe side.
constexpr float SINGLE_SLACK = 1e-6F;

bool share_node(const Surface::Edge& a, const Surface::Edge& b) {
  return a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1];
}

bool has_node(const Surface::Triangle& triangle, std::int32_t node) {
  return triangle[0] == node || triangle[1] == node || triangle[2] == node;
}

/// Where the primitives of each part begin: they come part by part.
template <class Primitives, class NodeOf>
std::vector<std::size_t> first_of_parts(const Surface& surface, const Primitives& primitives, const NodeOf& node_of) {
  std::vector<std::size_t> first(static_cast<std::size_t>(surface.part_count()) + 1, 0);
  for (const auto& primitive : primitives)
    ++first[static_cast<std::size_t>(surface.part_of_node(node_of(primitive))) + 1];
  for (std::size_t part = 1; part < first.size(); ++part)
    first[part] += first[part - 1];
  return first;
}

/// A plane across the way between the nearest points shows how far apart they are at least, whatever was rounded in
/// finding it.
double proven_distance(PairKind kind, const PairPoints& points) {
  const Vec3 normal = separating_direction(kind, points);
  const int first = kind == PairKind::edge_edge ? 2 : 1;
  double gap = std::numeric_limits<double>::infinity();
  double size = 0.0;
  for (int a = 0; a < first; ++a) {
    for (int b = first; b < 4; ++b) {
      const Vec3 way = points.row(a) - points.row(b);
      gap = std::min(gap, normal.dot(way));
      size = std::max(size, way.cwiseAbs().sum());
    }
  }
  return std::max(0.0, gap - 16.0 * std::numeric_limits<double>::epsilon() * size);
}

PairPoints gather(const Points& x, const std::array<std::int32_t, 4>& nodes) {
  PairPoints points;
  for (int k = 0; k < 4; ++k)
    points.row(k) = x.row(nodes[static_cast<std::size_t>(k)]);
  return points;
}

} // namespace

BroadPhase::BroadPhase(const Surface& surface, const Threads& threads, std::size_t most_pairs,
                       ReachFunction reach_within)
    : m_surface(surface)
    , m_threads(threads)
    , m_most_pairs(most_pairs)
    , m_reach_within(std::move(reach_within))
    , m_first_point(first_of_parts(surface, surface.points(), [](std::int32_t point) { return point; }))
    , m_first_edge(first_of_parts(surface, surface.edges(), [](const Surface::Edge& edge) { return edge[0]; }))
    , m_first_triangle(
          first_of_parts(surface, surface.triangles(), [](const Surface::Triangle& triangle) { return triangle[0]; }))
    , m_triangle_trees(static_cast<std::size_t>(surface.part_count()))
    , m_edge_trees(static_cast<std::size_t>(surface.part_count()))
    , m_partners(static_cast<std::size_t>(surface.part_count())) {
  for (int a = 0; a < surface.part_count(); ++a) {
    for (int b = 0; b <= a; ++b) {
      if (surface.meet(a, b))
        m_lists[static_cast<std::size_t>(a == b ? PairGroup::within_parts : PairGroup::between_parts)].needed = true;
    }
  }
}

Points BroadPhase::middles_of(const Points& positions, PairGroup group) const {
  Points middles = Points::Zero(m_surface.part_count(), 3);
  if (group == PairGroup::between_parts)
    return middles;
  const std::vector<std::int32_t>& points = m_surface.points();
  for (Eigen::Index part = 0; part < middles.rows(); ++part) {
    const std::size_t begin = m_first_point[static_cast<std::size_t>(part)];
    const std::size_t end = m_first_point[static_cast<std::size_t>(part) + 1];
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = begin; i < end; ++i)
      sum += positions.row(points[i]).transpose();
    if (end > begin)
      middles.row(part) = sum.transpose() / static_cast<double>(end - begin);
  }
  return middles;
}

void BroadPhase::measure_ways(PairGroup group, const Points& positions, Ways& out) const {
  const Points& since = lists(group).measured_at;
  out.measure(m_surface, since, middles_of(since, group), positions, middles_of(positions, group));
}

bool BroadPhase::hold(const std::vector<Box>& rooms, const Points& positions, const Points& middles) const {
  for (const std::int32_t node : m_surface.points()) {
    const double* x = positions.data() + 3 * static_cast<std::ptrdiff_t>(node);
    const double* middle = middles.data() + 3 * static_cast<std::ptrdiff_t>(m_surface.part_of_node(node));
    const Box& room = rooms[node];
    for (int i = 0; i < 3; ++i) {
      const double place = x[i] - middle[i];
      if (!(place >= room.low[i] && place <= room.high[i]))
        return false;
    }
  }
  return true;
}

bool BroadPhase::hold(const std::vector<Box>& rooms, PairGroup group, const Points& from, const Points& to) const {
  return hold(rooms, to, middles_of(to, group)) && (&from == &to || hold(rooms, from, middles_of(from, group)));
}

double BroadPhase::longest_way(const Points& from, const Points& to, PairGroup group) const {
  if (&from == &to)
    return 0.0;
  const Points flown = middles_of(to, group) - middles_of(from, group);
  double longest = 0.0;
  for (const std::int32_t node : m_surface.points()) {
    const Eigen::RowVector3d way = to.row(node) - from.row(node) - flown.row(m_surface.part_of_node(node));
    longest = std::max(longest, way.cwiseAbs().maxCoeff());
  }
  return longest;
}

void BroadPhase::give_rooms(const Points& from, const Points& to, PairGroup group, double margin) {
  const Points from_middles = middles_of(from, group);
  const Points to_middles = middles_of(to, group);
  std::vector<Box>& rooms = m_lists[static_cast<std::size_t>(group)].rooms;
  rooms.resize(static_cast<std::size_t>(m_surface.node_count()));
  for (const std::int32_t node : m_surface.points()) {
    const int part = m_surface.part_of_node(node);
    for (int i = 0; i < 3; ++i) {
      const double a = from(node, i) - from_middles(part, i);
      const double b = to(node, i) - to_middles(part, i);
      // Those that move fast change their way by more.
      const double spare = margin + 0.1 * std::abs(b - a);
      const double beyond = b + std::clamp(STEPS_AHEAD * (b - a), -AHEAD * margin, AHEAD * margin);
      rooms[node].low[i] = std::min(a, beyond) - spare;
      rooms[node].high[i] = std::max(a, beyond) + spare;
    }
  }
}

bool BroadPhase::cover(const Points& from, const Points& to, double distance, double margin) {
  bool searched = false;
  bool fits = true;
  for (const PairGroup group : PAIR_GROUPS) {
    Lists& lists = m_lists[static_cast<std::size_t>(group)];
    if (!lists.needed)
      continue;
    // Lists for long ways are always made anew, so that whether they fit depends on these ways alone and not on what
    // was searched before: a run that is resumed must take the same steps.
    const double way = longest_way(from, to, group);
    const bool anew = way > LONG_WAY * margin ||
                      (&from != &to && lists.longest_way > TOO_LONG_WAY * margin && way < 0.25 * lists.longest_way);
    if (!lists.valid || anew || distance > lists.distance || !hold(lists.rooms, group, from, to)) {
      searched = true;
      give_rooms(from, to, group, margin);
      lists.longest_way = way;
      lists.distance = distance;
      lists.measured_at = from;
      lists.picked = false;
      lists.valid = search(group, distance);
    }
    if (!lists.valid) {
      for (const std::size_t kind : {0, 1}) {
        lists.pairs[kind].clear();
        lists.near[kind].clear();
      }
      fits = false;
      break;
    }
    if (!lists.picked || !is_picked_for(lists, from, middles_of(from, group)) ||
        !is_picked_for(lists, to, middles_of(to, group)))
      pick(from, to, group);
  }
  m_searches += searched ? 1 : 0;
  return fits;
}

/// Whether all nodes are in small boxes around places equally far along their ways. Such positions, and all between
/// two of them, are a convex set.
bool BroadPhase::is_picked_for(const Lists& lists, const Points& positions, const Points& middles) const {
  const std::vector<std::int32_t>& points = m_surface.points();
  double along = 0.0;
  double length = 0.0;
  for (const std::int32_t node : points) {
    const int part = m_surface.part_of_node(node);
    const Eigen::RowVector3d way = lists.picked_way.row(node);
    along += way.dot(positions.row(node) - middles.row(part) - lists.picked_from.row(node));
    length += way.squaredNorm();
  }
  const double share = length > 0.0 ? std::clamp(along / length, 0.0, 1.0) : 0.0;
  const double margin = SMALL_ROOM * lists.distance;
  return std::all_of(points.begin(), points.end(), [&](std::int32_t node) {
    const int part = m_surface.part_of_node(node);
    const Eigen::RowVector3d off =
        positions.row(node) - middles.row(part) - lists.picked_from.row(node) - share * lists.picked_way.row(node);
    return off.cwiseAbs().maxCoeff() <= margin;
  });
}

/// A pair is left out if it cannot come within the distance from places along its ways, given small boxes around them:
/// their corners are sqrt(3) margins away, and both sides may go there.
void BroadPhase::pick(const Points& from, const Points& to, PairGroup group) {
  Lists& lists = m_lists[static_cast<std::size_t>(group)];
  const double margin = SMALL_ROOM * lists.distance;
  const Points from_middles = middles_of(from, group);
  const Points to_middles = middles_of(to, group);
  lists.picked_from = from;
  lists.picked_way = to - from;
  for (const std::int32_t node : m_surface.points()) {
    const int part = m_surface.part_of_node(node);
    lists.picked_from.row(node) -= from_middles.row(part);
    lists.picked_way.row(node) -= to_middles.row(part) - from_middles.row(part);
  }
  const double spent = lists.distance + 2.0 * std::sqrt(3.0) * margin;
  measure_ways(group, from, m_from_ways);
  measure_ways(group, to, m_to_ways);
  for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
    const std::vector<CandidatePair>& pairs = lists.pairs[static_cast<std::size_t>(kind)];
    const std::size_t count = (pairs.size() + PICK_GRAIN - 1) / PICK_GRAIN;
    m_chunks.resize(std::max(m_chunks.size(), count));
    m_threads.for_chunks(pairs.size(), PICK_GRAIN, [&](std::size_t begin, std::size_t end) {
      std::vector<CandidatePair>& chunk = m_chunks[begin / PICK_GRAIN];
      chunk.clear();
      for (std::size_t i = begin; i < end; ++i) {
        const double spare = pairs[i].apart - spent;
        if (!m_to_ways.are_below(kind, pairs[i].nodes, spare) || !m_from_ways.are_below(kind, pairs[i].nodes, spare))
          chunk.push_back(pairs[i]);
      }
    });
    join_chunks(count, lists.near[static_cast<std::size_t>(kind)]);
  }
  lists.picked = true;
}

void BroadPhase::measure(PairKind kind, bool within, const Lists& lists, CandidatePair& pair) const {
  // Most are far enough from each other for their boxes to tell.
  double apart = std::sqrt(squared_box_distance(kind, lists.measured_at, pair.nodes));
  if (apart < 4.0 * lists.distance)
    apart = std::max(apart, proven_distance(kind, gather(lists.measured_at, pair.nodes)));
  pair.apart = static_cast<float>(apart) * (1.0F - SINGLE_SLACK);
  // The others need no limit: their distance tells.
  const bool limited = within && m_reach_within && apart < 2.0 * lists.distance;
  const double reach = limited ? m_reach_within(kind, pair.nodes) : lists.distance;
  pair.reach = static_cast<float>(std::min(reach, lists.distance)) * (1.0F + SINGLE_SLACK);
}

/// The first `count` chunks, one after the other. Millions of bytes: the threads share the copying.
void BroadPhase::join_chunks(std::size_t count, std::vector<CandidatePair>& out) {
  std::vector<std::size_t> begin(count + 1, 0);
  for (std::size_t chunk = 0; chunk < count; ++chunk)
    begin[chunk + 1] = begin[chunk] + m_chunks[chunk].size();
  out.resize(begin[count]);
  m_threads.for_each(count, 1, [&](std::size_t chunk) {
    std::copy(m_chunks[chunk].begin(), m_chunks[chunk].end(), out.begin() + static_cast<std::ptrdiff_t>(begin[chunk]));
  });
}

template <class Find>
bool BroadPhase::collect(std::size_t count, Lists& lists, PairKind kind, std::size_t room, const Find& find) {
  std::vector<CandidatePair>& out = lists.pairs[static_cast<std::size_t>(kind)];
  const bool within = &lists == &m_lists[static_cast<std::size_t>(PairGroup::within_parts)];
  m_chunks.resize(std::max(m_chunks.size(), (count + GRAIN - 1) / GRAIN));
  std::atomic<std::size_t> total = 0;
  m_threads.for_chunks(count, GRAIN, [&](std::size_t begin, std::size_t end) {
    std::vector<CandidatePair>& chunk = m_chunks[begin / GRAIN];
    chunk.clear();
    for (std::size_t i = begin; i < end && total <= room; ++i) {
      const std::size_t before = chunk.size();
      find(static_cast<std::int32_t>(i), chunk);
      total += chunk.size() - before;
      // The tree's order depends on when it was built; sums over pairs must not.
      std::sort(chunk.begin() + static_cast<std::ptrdiff_t>(before), chunk.end(),
                [](const CandidatePair& a, const CandidatePair& b) { return a.second < b.second; });
    }
    for (std::size_t i = 0; i < chunk.size() && total <= room; ++i)
      measure(kind, within, lists, chunk[i]);
  });
  if (total > room)
    return false;
  join_chunks((count + GRAIN - 1) / GRAIN, out);
  return true;
}

void BroadPhase::build_trees(const std::vector<Box>& rooms) {
  const std::vector<Surface::Triangle>& triangles = m_surface.triangles();
  const std::vector<Surface::Edge>& edges = m_surface.edges();
  m_triangle_boxes.resize(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    m_triangle_boxes[i] = rooms[triangles[i][0]];
    m_triangle_boxes[i].include(rooms[triangles[i][1]]);
    m_triangle_boxes[i].include(rooms[triangles[i][2]]);
  }
  m_edge_boxes.resize(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    m_edge_boxes[i] = rooms[edges[i][0]];
    m_edge_boxes[i].include(rooms[edges[i][1]]);
  }
  m_threads.for_each(2 * m_triangle_trees.size(), 1, [&](std::size_t tree) {
    const std::size_t part = tree / 2;
    if (tree % 2 == 0)
      m_triangle_trees[part].update(m_triangle_boxes, m_first_triangle[part], m_first_triangle[part + 1]);
    else
      m_edge_trees[part].update(m_edge_boxes, m_first_edge[part], m_first_edge[part + 1]);
  });
}

/// Parts whose boxes, grown by the distance, meet.
void BroadPhase::find_partners(PairGroup group, double distance) {
  const std::vector<Box>& rooms = m_lists[static_cast<std::size_t>(group)].rooms;
  const int parts = m_surface.part_count();
  std::vector<Box> bounds(static_cast<std::size_t>(parts));
  for (int part = 0; part < parts; ++part) {
    const std::size_t begin = m_first_point[static_cast<std::size_t>(part)];
    const std::size_t end = m_first_point[static_cast<std::size_t>(part) + 1];
    if (begin == end)
      continue;
    Box box = rooms[m_surface.points()[begin]];
    for (std::size_t i = begin; i < end; ++i)
      box.include(rooms[m_surface.points()[i]]);
    bounds[static_cast<std::size_t>(part)] = box;
  }
  for (int a = 0; a < parts; ++a) {
    std::vector<int>& partners = m_partners[static_cast<std::size_t>(a)];
    partners.clear();
    Box box = bounds[static_cast<std::size_t>(a)];
    box.grow(distance);
    for (int b = 0; b < parts; ++b) {
      const bool wanted = (group == PairGroup::within_parts) == (a == b) && m_surface.meet(a, b);
      if (wanted && bounds[static_cast<std::size_t>(b)].meets(box))
        partners.push_back(b);
    }
  }
}

bool BroadPhase::search(PairGroup group, double distance) {
  Lists& lists = m_lists[static_cast<std::size_t>(group)];
  const std::vector<Surface::Triangle>& triangles = m_surface.triangles();
  const std::vector<Surface::Edge>& edges = m_surface.edges();
  const std::vector<std::int32_t>& points = m_surface.points();
  build_trees(lists.rooms);
  find_partners(group, distance);
  const bool fits = collect(points.size(), lists, PairKind::point_triangle, m_most_pairs,
                            [&](std::int32_t i, std::vector<CandidatePair>& out) {
                              Box box = lists.rooms[points[i]];
                              box.grow(distance);
                              const auto take = [&](std::int32_t j) {
                                const Surface::Triangle& t = triangles[j];
                                if (!has_node(t, points[i]))
                                  out.push_back({{points[i], t[0], t[1], t[2]}, i, j});
                              };
                              for (const int other : m_partners[m_surface.part_of_node(points[i])])
                                m_triangle_trees[other].query(box, take);
                            });
  return fits && collect(edges.size(), lists, PairKind::edge_edge, m_most_pairs - lists.pairs[0].size(),
                         [&](std::int32_t i, std::vector<CandidatePair>& out) {
                           Box box = m_edge_boxes[i];
                           box.grow(distance);
                           const Surface::Edge& e = edges[i];
                           const auto take = [&](std::int32_t j) {
                             const Surface::Edge& f = edges[j];
                             if (!share_node(e, f))
                               out.push_back({{e[0], e[1], f[0], f[1]}, i, j});
                           };
                           const int part = m_surface.part_of_node(e[0]);
                           for (const int other : m_partners[part]) {
                             if (other >= part)
                               m_edge_trees[other].query(box, take, i);
                           }
                         });
}

std::size_t BroadPhase::pair_count() const {
  std::size_t count = 0;
  for (const Lists& lists : m_lists)
    count += lists.pairs[0].size() + lists.pairs[1].size();
  return count;
}

std::size_t BroadPhase::memory_bytes() const {
  std::size_t bytes = 2 * (m_triangle_boxes.capacity() + m_edge_boxes.capacity()) * sizeof(Box);
  for (const Lists& lists : m_lists) {
    bytes += (lists.pairs[0].capacity() + lists.pairs[1].capacity()) * sizeof(CandidatePair);
    bytes += (lists.near[0].capacity() + lists.near[1].capacity()) * sizeof(CandidatePair);
    bytes += static_cast<std::size_t>(lists.picked_from.size() + lists.picked_way.size()) * sizeof(double);
    bytes += lists.rooms.capacity() * sizeof(Box) + static_cast<std::size_t>(lists.measured_at.size()) * sizeof(double);
  }
  for (const std::vector<CandidatePair>& chunk : m_chunks)
    bytes += chunk.capacity() * sizeof(CandidatePair);
  return bytes;
}

std::vector<CandidatePair> all_pairs(const Surface& surface, PairKind kind) {
  std::vector<CandidatePair> pairs;
  const auto& edges = surface.edges();
  const auto& triangles = surface.triangles();
  const auto& points = surface.points();
  if (kind == PairKind::edge_edge) {
    for (std::size_t i = 0; i < edges.size(); ++i) {
      for (std::size_t j = i + 1; j < edges.size(); ++j) {
        if (surface.meet(surface.part_of_node(edges[i][0]), surface.part_of_node(edges[j][0])) &&
            !share_node(edges[i], edges[j]))
          pairs.push_back({{edges[i][0], edges[i][1], edges[j][0], edges[j][1]},
                           static_cast<std::int32_t>(i),
                           static_cast<std::int32_t>(j)});
      }
    }
    return pairs;
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < triangles.size(); ++j) {
      const Surface::Triangle& t = triangles[j];
      if (surface.meet(surface.part_of_node(points[i]), surface.part_of_node(t[0])) && !has_node(t, points[i]))
        pairs.push_back({{points[i], t[0], t[1], t[2]}, static_cast<std::int32_t>(i), static_cast<std::int32_t>(j)});
    }
  }
  return pairs;
}

} // namespace wry::contact
