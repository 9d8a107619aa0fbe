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
constexpr std::size_t GROUP = BoxSearch<Box>::GROUP;
/// Rooms go on beyond the end of a way by this many times as much, where the next steps go, at most by so many margins.
constexpr double STEPS_AHEAD = 2.0;
constexpr double AHEAD = 2.0;
/// Ways longer than so many margins are searched for themselves: a list with rooms for them would be too long, and be
/// left at once by what follows.
constexpr double LONG_WAY = 4.0;
/// A list pays when it serves so often: making it takes as long as so many searches for one way.
constexpr int PAYS = 4;
/// The radius of the small balls around places along the ways, as a share of the distance.
constexpr double SMALL_BALL = 0.45;
constexpr std::size_t PICK_GRAIN = 2048;
/// Numbers that are kept in single precision are moved by this share to the safe side.
constexpr float SINGLE_SLACK = 1e-6F;

template <class Primitive> bool has_node(const Primitive& primitive, std::int32_t node) {
  return std::find(primitive.begin(), primitive.end(), node) != primitive.end();
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

/// The order in which trees find pairs depends on when they were built; sums over pairs must not.
void sort_pairs(std::vector<CandidatePair>& pairs, std::size_t begin) {
  std::sort(pairs.begin() + static_cast<std::ptrdiff_t>(begin), pairs.end(),
            [](const CandidatePair& a, const CandidatePair& b) {
              return a.first != b.first ? a.first < b.first : a.second < b.second;
            });
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
    , m_first_point(first_points_of_parts(surface))
    , m_room_search(surface, threads)
    , m_moving_search(surface, threads) {
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
  measure_ways(group, lists(group).near_measured_at, positions, out);
}

void BroadPhase::measure_ways(PairGroup group, const Points& since, const Points& positions, Ways& out) const {
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
  const int searches = m_searches;
  for (const PairGroup group : PAIR_GROUPS) {
    Lists& lists = m_lists[static_cast<std::size_t>(group)];
    if (!lists.needed || cover_group(group, from, to, distance, margin))
      continue;
    lists.near_valid = false;
    for (const std::size_t kind : {0, 1})
      lists.near[kind].clear();
    return false;
  }
  m_searches = std::min(m_searches, searches + 1);
  return true;
}

bool BroadPhase::cover_group(PairGroup group, const Points& from, const Points& to, double distance, double margin) {
  Lists& lists = m_lists[static_cast<std::size_t>(group)];
  const double way = longest_way(from, to, group);
  // Long ways are always searched for, so that whether their pairs fit depends on them alone and not on what was
  // searched before: a run that is resumed must take the same steps.
  if (way > LONG_WAY * margin) {
    lists.unserved = 0;
    if (search_moving(from, to, group, distance))
      return true;
    const bool fits = make_list(from, to, group, distance, margin);
    lists.valid = false; // too long for short ways
    return fits;
  }
  if (lists.near_valid && distance <= lists.near_distance && is_near_valid_for(lists, group, from) &&
      (&from == &to || is_near_valid_for(lists, group, to)) &&
      (!lists.near_is_picked || hold(lists.rooms, group, from, to)))
    return true;
  if (lists.valid && distance <= lists.distance && hold(lists.rooms, group, from, to)) {
    ++lists.served;
    pick(from, to, group);
    return true;
  }
  // When the last list was soon left, the next is made only after it would have paid.
  const bool pays = lists.served >= PAYS || ++lists.unserved >= PAYS;
  if (!pays && search_moving(from, to, group, distance))
    return true;
  lists.served = 1;
  lists.unserved = 0;
  return make_list(from, to, group, distance, margin) || (pays && search_moving(from, to, group, distance));
}

/// A list in double precision, for which boxes in single precision may be too coarse, and the pairs picked from it.
bool BroadPhase::make_list(const Points& from, const Points& to, PairGroup group, double distance, double margin) {
  Lists& lists = m_lists[static_cast<std::size_t>(group)];
  give_rooms(from, to, group, margin);
  lists.measured_at = from;
  lists.valid = search_rooms(group, distance);
  if (lists.valid)
    pick(from, to, group);
  return lists.valid;
}

/// Whether all nodes are in small balls around places equally far along their ways. Such positions, and all between
/// two of them, are a convex set.
bool BroadPhase::is_near_valid_for(const Lists& lists, PairGroup group, const Points& positions) const {
  const double ball = SMALL_BALL * lists.near_distance;
  const Points middles = middles_of(positions, group);
  const std::vector<std::int32_t>& points = m_surface.points();
  double along = 0.0;
  double length = 0.0;
  for (const std::int32_t node : points) {
    const int part = m_surface.part_of_node(node);
    const Eigen::RowVector3d way = lists.near_way.row(node);
    along += way.dot(positions.row(node) - middles.row(part) - lists.near_from.row(node));
    length += way.squaredNorm();
  }
  const double share = length > 0.0 ? std::clamp(along / length, 0.0, 1.0) : 0.0;
  return std::all_of(points.begin(), points.end(), [&](std::int32_t node) {
    const int part = m_surface.part_of_node(node);
    const Eigen::RowVector3d off =
        positions.row(node) - middles.row(part) - lists.near_from.row(node) - share * lists.near_way.row(node);
    return off.squaredNorm() <= ball * ball;
  });
}

void BroadPhase::set_ways(const Points& from, const Points& to, PairGroup group, double distance) {
  Lists& lists = m_lists[static_cast<std::size_t>(group)];
  const Points from_middles = middles_of(from, group);
  const Points to_middles = middles_of(to, group);
  lists.near_from = from;
  lists.near_way = to - from;
  for (const std::int32_t node : m_surface.points()) {
    const int part = m_surface.part_of_node(node);
    lists.near_from.row(node) -= from_middles.row(part);
    lists.near_way.row(node) -= to_middles.row(part) - from_middles.row(part);
  }
  lists.near_distance = distance;
  lists.near_valid = true;
}

/// A pair is left out if it cannot come within the distance from places along its ways, given small balls around them.
void BroadPhase::pick(const Points& from, const Points& to, PairGroup group) {
  Lists& lists = m_lists[static_cast<std::size_t>(group)];
  set_ways(from, to, group, lists.distance);
  lists.near_is_picked = true;
  lists.near_measured_at = lists.measured_at;
  const double spent = (1.0 + 2.0 * SMALL_BALL) * lists.distance;
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
    sort_pairs(lists.near[static_cast<std::size_t>(kind)], 0);
  }
}

/// With the moving boxes of the nodes there, from which rounding takes so much.
void BroadPhase::measure(PairKind kind, PairGroup group, const Points& at, double distance, double rounding,
                         CandidatePair& pair) const {
  // Most are far enough from each other for the direction between their middles to tell, or their boxes.
  const double enough = 4.0 * distance;
  double apart = std::max(0.0, middle_distance(kind, pair.nodes, m_moving_boxes, rounding));
  if (apart < enough)
    apart = std::max(apart, std::sqrt(squared_box_distance(kind, at, pair.nodes)));
  if (apart < enough)
    apart = std::max(apart, proven_distance(kind, gather(at, pair.nodes)));
  pair.apart = static_cast<float>(apart) * (1.0F - SINGLE_SLACK);
  // The others need no limit: their distance tells.
  const bool limited = group == PairGroup::within_parts && m_reach_within && apart < 2.0 * distance;
  const double reach = limited ? m_reach_within(kind, pair.nodes) : distance;
  pair.reach = static_cast<float>(std::min(reach, distance)) * (1.0F + SINGLE_SLACK);
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

/// How many were found, or that they are more than there is room for.
std::size_t BroadPhase::collect(std::size_t count, std::size_t room, const Find& find, const Finish& finish,
                                std::vector<CandidatePair>& out) {
  m_chunks.resize(std::max(m_chunks.size(), (count + GRAIN - 1) / GRAIN));
  std::atomic<std::size_t> total = 0;
  m_threads.for_chunks(count, GRAIN, [&](std::size_t begin, std::size_t end) {
    std::vector<CandidatePair>& chunk = m_chunks[begin / GRAIN];
    chunk.clear();
    for (std::size_t i = begin; i < end && total <= room; i += GROUP) {
      const std::size_t before = chunk.size();
      find(static_cast<std::int32_t>(i), static_cast<std::int32_t>(std::min(end, i + GROUP)), chunk);
      total += chunk.size() - before;
      finish(chunk, before);
    }
  });
  if (total <= room)
    join_chunks((count + GRAIN - 1) / GRAIN, out);
  return total;
}

template <class AnyBox>
bool BroadPhase::search(const BoxSearch<AnyBox>& boxes, const std::function<Finish(PairKind)>& finish, PairLists& out) {
  ++m_searches;
  const std::size_t triangles = collect(
      m_surface.points().size(), m_most_pairs,
      [&](std::int32_t begin, std::int32_t end, std::vector<CandidatePair>& found) {
        boxes.add_triangles(begin, end, found);
      },
      finish(PairKind::point_triangle), out[static_cast<std::size_t>(PairKind::point_triangle)]);
  if (triangles > m_most_pairs)
    return false;
  const std::size_t room = m_most_pairs - triangles;
  return collect(
             m_surface.edges().size(), room,
             [&](std::int32_t begin, std::int32_t end, std::vector<CandidatePair>& found) {
               boxes.add_edges(begin, end, found);
             },
             finish(PairKind::edge_edge), out[static_cast<std::size_t>(PairKind::edge_edge)]) <= room;
}

bool BroadPhase::search_rooms(PairGroup group, double distance) {
  Lists& lists = m_lists[static_cast<std::size_t>(group)];
  lists.distance = distance;
  m_room_search.update(lists.rooms, group, distance);
  const double rounding = rounding_of_boxes(put_moving_boxes(lists.measured_at, {}));
  const auto measure_all = [&](PairKind kind) -> Finish {
    return [&, kind](std::vector<CandidatePair>& pairs, std::size_t begin) {
      for (std::size_t i = begin; i < pairs.size(); ++i)
        measure(kind, group, lists.measured_at, distance, rounding, pairs[i]);
    };
  };
  const bool fits = search(m_room_search, measure_all, lists.pairs);
  for (const std::size_t kind : {0, 1}) {
    if (!fits)
      lists.pairs[kind].clear();
  }
  return fits;
}

/// Without `ways`, nodes stand still. Returns the largest coordinate, of a place or a way.
double BroadPhase::put_moving_boxes(const Points& places, const Points& ways) {
  const std::vector<std::int32_t>& points = m_surface.points();
  Vec3 origin = Vec3::Zero(); // of the scene, so that single precision tells its parts apart wherever it is
  for (const std::int32_t node : points)
    origin += places.row(node).transpose() / static_cast<double>(points.size());
  m_moving_boxes.resize(static_cast<std::size_t>(m_surface.node_count()));
  double most = 0.0;
  for (const std::int32_t node : points) {
    Eigen::Array4f place = Eigen::Array4f::Zero();
    Eigen::Array4f way = Eigen::Array4f::Zero();
    for (int i = 0; i < 3; ++i) {
      const double x = places(node, i) - origin[i];
      const double w = ways.rows() > 0 ? ways(node, i) : 0.0;
      place[i] = static_cast<float>(x);
      way[i] = static_cast<float>(w);
      most = std::max({most, std::abs(x), std::abs(w)});
    }
    m_moving_boxes[static_cast<std::size_t>(node)] = MovingBox::of(place, way);
  }
  return most;
}

/// What `pick` would pick, without a list.
bool BroadPhase::search_moving(const Points& from, const Points& to, PairGroup group, double distance) {
  Lists& lists = m_lists[static_cast<std::size_t>(group)];
  set_ways(from, to, group, distance);
  lists.near_is_picked = false;
  lists.near_measured_at = from;
  const double spent = (1.0 + 2.0 * SMALL_BALL) * distance;
  const double rounding = rounding_of_boxes(put_moving_boxes(lists.near_from, lists.near_way) + spent);
  m_moving_search.update(m_moving_boxes, group, spent + rounding);
  measure_ways(group, to, m_to_ways);
  const auto keep_near = [&](PairKind kind) -> Finish {
    return [&, kind](std::vector<CandidatePair>& pairs, std::size_t begin) {
      std::size_t kept = begin;
      for (std::size_t i = begin; i < pairs.size(); ++i) {
        if (stay_apart(kind, pairs[i].nodes, m_moving_boxes, spent, rounding))
          continue;
        measure(kind, group, from, distance, rounding, pairs[i]);
        if (!m_to_ways.are_below(kind, pairs[i].nodes, pairs[i].apart - spent))
          pairs[kept++] = pairs[i];
      }
      pairs.resize(kept);
      sort_pairs(pairs, begin);
    };
  };
  return search(m_moving_search, keep_near, lists.near);
}

std::size_t BroadPhase::pair_count() const {
  std::size_t count = 0;
  for (const Lists& lists : m_lists) {
    for (const PairLists* pairs : {&lists.pairs, &lists.near})
      count += (*pairs)[0].size() + (*pairs)[1].size();
  }
  return count;
}

std::size_t BroadPhase::memory_bytes() const {
  std::size_t bytes = m_room_search.memory_bytes() + m_moving_search.memory_bytes();
  bytes += m_moving_boxes.capacity() * sizeof(MovingBox);
  for (const Lists& lists : m_lists) {
    for (const PairLists* pairs : {&lists.pairs, &lists.near})
      bytes += ((*pairs)[0].capacity() + (*pairs)[1].capacity()) * sizeof(CandidatePair);
    for (const Points* points : {&lists.near_from, &lists.near_way, &lists.measured_at, &lists.near_measured_at})
      bytes += static_cast<std::size_t>(points->size()) * sizeof(double);
    bytes += lists.rooms.capacity() * sizeof(Box);
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
        const Surface::Edge& e = edges[i];
        if (surface.meet(surface.part_of_node(e[0]), surface.part_of_node(edges[j][0])) && !has_node(edges[j], e[0]) &&
            !has_node(edges[j], e[1]))
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
