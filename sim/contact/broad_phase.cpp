#include "sim/contact/broad_phase.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "sim/contact/distance.h"
#include "sim/contact/pair_boxes.h"
#include "sim/contact/select_search.h"

namespace wry::contact {

namespace {

constexpr std::size_t GRAIN = 128;
/// So many primitives are looked up before their pairs are looked at.
constexpr std::size_t GROUP = 32;
/// A list's ways go on, where the next steps go: for so many times as long, at most by so many margins.
constexpr double STEPS_AHEAD = 8.0;
constexpr double AHEAD = 8.0;
/// Ways longer than so many margins are searched for themselves: a list for them would be too long, and be left at once
/// by what follows.
constexpr double LONG_WAY = 4.0;
/// A list pays when it serves so often: making it takes as long as so many searches for one way.
constexpr int PAYS = 3;
/// The radius of the small balls around places along the ways, as a share of the distance.
constexpr double SMALL_BALL = 0.45;
/// How far along the ways nodes are is guessed from every so-manieth.
constexpr std::size_t SAMPLED = 8;
/// Who is farther apart than so many distances is not measured exactly.
constexpr double ENOUGH = 3.0;
constexpr std::size_t PICK_GRAIN = 2048;
/// Pairs that a kernel is given at once.
constexpr std::size_t BLOCK = 256;
/// Numbers that are kept in single precision are moved by this share to the safe side.
constexpr float SINGLE_SLACK = 1e-6F;

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

} // namespace

BroadPhase::BroadPhase(const Surface& surface, const Threads& threads, std::size_t most_pairs,
                       ReachFunction reach_within, Isa isa)
    : m_surface(surface)
    , m_threads(threads)
    , m_most_pairs(most_pairs)
    , m_reach_within(std::move(reach_within))
    , m_kernels(select_search(isa))
    , m_first_point(first_points_of_parts(surface))
    , m_boxes(surface, threads, m_kernels.single) {
  for (int a = 0; a < surface.part_count(); ++a) {
    for (int b = 0; b <= a; ++b) {
      if (surface.meet(a, b))
        m_lists[static_cast<std::size_t>(a == b ? PairGroup::within_parts : PairGroup::between_parts)].needed = true;
    }
  }
}

Placed BroadPhase::seen(const Points& positions, PairGroup group) const {
  Placed placed{positions, Points::Zero(m_surface.part_count(), 3)};
  Points& middles = placed.middles;
  if (group == PairGroup::between_parts)
    return placed;
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
  return placed;
}

void BroadPhase::measure_ways(PairGroup group, const Points& first, const Points& second, Ways& out) const {
  const Placed at = seen(first, group);
  const Placed since = seen(lists(group).near.measured_at, group);
  if (&first == &second)
    out.measure(m_surface, m_kernels, since, at, at);
  else
    out.measure(m_surface, m_kernels, since, at, seen(second, group));
}

double BroadPhase::longest_way_within(const Points& from, const Points& to) const {
  return &from == &to ? 0.0 : longest_way(seen(from, PairGroup::within_parts), seen(to, PairGroup::within_parts));
}

double BroadPhase::longest_way(const Placed& from, const Placed& to) const {
  const Points flown = to.middles - from.middles;
  double longest = 0.0;
  for (const std::int32_t node : m_surface.points()) {
    const Eigen::RowVector3d way =
        to.positions.row(node) - from.positions.row(node) - flown.row(m_surface.part_of_node(node));
    longest = std::max(longest, way.cwiseAbs().maxCoeff());
  }
  return longest;
}

bool BroadPhase::cover(const Points& from, const Points& to, double distance, double margin) {
  const int searches = m_searches;
  for (const PairGroup group : PAIR_GROUPS) {
    Lists& lists = m_lists[static_cast<std::size_t>(group)];
    if (!lists.needed || cover_group(group, seen(from, group), seen(to, group), distance, margin))
      continue;
    lists.near.valid = false;
    for (std::vector<CandidatePair>& pairs : lists.near.pairs)
      pairs.clear();
    return false;
  }
  m_searches = std::min(m_searches, searches + 1);
  return true;
}

bool BroadPhase::cover_group(PairGroup group, const Placed& from, const Placed& to, double distance, double margin) {
  Lists& lists = m_lists[static_cast<std::size_t>(group)];
  // Long ways are always searched for, so that whether their pairs fit depends on them alone and not on what was
  // searched before: a run that is resumed must take the same steps.
  if (longest_way(from, to) > LONG_WAY * margin) {
    lists.unserved = 0;
    return search_near(group, from, to, distance);
  }
  const bool listed = lists.list.valid && distance <= lists.list.distance && holds(lists.list, from, to);
  if (lists.near.valid && distance <= lists.near.distance && (listed || !lists.near_is_picked) &&
      holds(lists.near, from, to))
    return true;
  if (listed) {
    ++lists.served;
    pick(group, from, to);
    return true;
  }
  // When the last list was soon left, the next is made only after it would have paid.
  const bool pays = lists.served >= PAYS || ++lists.unserved >= PAYS;
  if (!pays && search_near(group, from, to, distance))
    return true;
  lists.served = 1;
  lists.unserved = 0;
  return make_list(group, from, to, distance, margin) || (pays && search_near(group, from, to, distance));
}

/// A list, and the pairs picked from it.
bool BroadPhase::make_list(PairGroup group, const Placed& from, const Placed& to, double distance, double margin) {
  PairSet& list = m_lists[static_cast<std::size_t>(group)].list;
  const auto go_on = [&](const Placed& end, double way) {
    set_ways(list, from, end, distance);
    list.ball = margin;
    list.way *= way > 0.0 ? std::clamp(AHEAD * margin / way, 1.0, STEPS_AHEAD) : 1.0;
  };
  // A correction of Newton's tells nothing about the steps to come; those that go far will not ask for this list.
  bool expects = m_expected_ways.rows() > 0;
  if (expects) {
    const Points end = from.positions + m_expected_ways;
    const Placed ahead = seen(end, group);
    const double way = longest_way(from, ahead);
    go_on(ahead, way);
    expects = way <= LONG_WAY * margin && holds(list, to);
  }
  if (!expects)
    go_on(to, longest_way(from, to));
  list.valid = search(list, group);
  if (list.valid)
    pick(group, from, to);
  return list.valid;
}

/// Whether all nodes are in balls around places equally far along their ways. Such positions, and all between two of
/// them, are a convex set.
bool BroadPhase::holds(const PairSet& set, const Placed& at) const {
  const std::vector<std::int32_t>& points = m_surface.points();
  const auto from_start = [&](std::int32_t node) -> Eigen::RowVector3d {
    return at.positions.row(node) - at.middles.row(m_surface.part_of_node(node)) - set.from.row(node);
  };
  double along = 0.0;
  double length = 0.0;
  for (std::size_t i = 0; i < points.size(); i += SAMPLED) {
    const Eigen::RowVector3d way = set.way.row(points[i]);
    along += way.dot(from_start(points[i]));
    length += way.squaredNorm();
  }
  const double share = length > 0.0 ? std::clamp(along / length, 0.0, 1.0) : 0.0;
  return std::all_of(points.begin(), points.end(), [&](std::int32_t node) {
    return (from_start(node) - share * set.way.row(node)).squaredNorm() <= set.ball * set.ball;
  });
}

bool BroadPhase::holds(const PairSet& set, const Placed& from, const Placed& to) const {
  return holds(set, to) && (&from.positions == &to.positions || holds(set, from));
}

void BroadPhase::set_ways(PairSet& set, const Placed& from, const Placed& to, double distance) const {
  set.from = from.positions;
  set.way = to.positions - from.positions;
  for (const std::int32_t node : m_surface.points()) {
    const int part = m_surface.part_of_node(node);
    set.from.row(node) -= from.middles.row(part);
    set.way.row(node) -= to.middles.row(part) - from.middles.row(part);
  }
  set.measured_at = from.positions;
  set.distance = distance;
  set.ball = SMALL_BALL * distance;
  set.valid = true;
}

/// A pair is left out if it cannot come within the distance from places along its ways, given small balls around them.
void BroadPhase::pick(PairGroup group, const Placed& from, const Placed& to) {
  Lists& lists = m_lists[static_cast<std::size_t>(group)];
  set_ways(lists.near, from, to, lists.list.distance);
  lists.near_is_picked = true;
  lists.near.measured_at = lists.list.measured_at;
  m_ways.measure(m_surface, m_kernels, seen(lists.near.measured_at, group), from, to);
  for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
    const std::vector<CandidatePair>& pairs = lists.list.pairs[static_cast<std::size_t>(kind)];
    const std::size_t count = (pairs.size() + PICK_GRAIN - 1) / PICK_GRAIN;
    m_chunks.resize(std::max(m_chunks.size(), count));
    m_moved.resize(std::max(m_moved.size(), count));
    m_threads.for_chunks(pairs.size(), PICK_GRAIN, [&](std::size_t begin, std::size_t end) {
      std::vector<std::int32_t>& moved = m_moved[begin / PICK_GRAIN];
      m_ways.find_moved(kind, pairs, begin, end, lists.near.spent(), moved);
      std::vector<CandidatePair>& chunk = m_chunks[begin / PICK_GRAIN];
      chunk.clear();
      for (const std::int32_t i : moved)
        chunk.push_back(pairs[static_cast<std::size_t>(i)]);
    });
    std::vector<CandidatePair>& near = lists.near.pairs[static_cast<std::size_t>(kind)];
    join_chunks(count, near);
    sort_pairs(near, 0);
  }
}

/// `known` is what they are apart at least.
void BroadPhase::measure(PairKind kind, PairGroup group, const PairSet& set, double known, CandidatePair& pair) const {
  // Most are far enough from each other for what is known to do, or their boxes.
  const double enough = ENOUGH * set.distance;
  double apart = std::max(0.0, known);
  if (apart < enough)
    apart = std::max(apart, std::sqrt(squared_box_distance(kind, set.measured_at, pair.nodes)));
  if (apart < enough)
    apart = std::max(apart, proven_distance(kind, gather(set.measured_at, pair.nodes)));
  pair.apart = static_cast<float>(apart) * (1.0F - SINGLE_SLACK);
  // The others need no limit: their distance tells.
  const bool limited = group == PairGroup::within_parts && m_reach_within && apart < 2.0 * set.distance;
  const double reach = limited ? m_reach_within(kind, pair.nodes) : set.distance;
  pair.reach = static_cast<float>(std::min(reach, set.distance)) * (1.0F + SINGLE_SLACK);
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

/// What `pick` would pick, without a list.
bool BroadPhase::search_near(PairGroup group, const Placed& from, const Placed& to, double distance) {
  Lists& lists = m_lists[static_cast<std::size_t>(group)];
  set_ways(lists.near, from, to, distance);
  lists.near_is_picked = false;
  return search(lists.near, group);
}

bool BroadPhase::search(PairSet& set, PairGroup group) {
  ++m_searches;
  if (search(m_boxes, set, group))
    return true;
  if (!m_wide_boxes)
    m_wide_boxes.reset(new Boxes<double>(m_surface, m_threads, m_kernels.wide));
  return search(*m_wide_boxes, set, group);
}

template <class Scalar> bool BroadPhase::search(Boxes<Scalar>& boxes, PairSet& set, PairGroup group) {
  const double spent = set.spent();
  const bool sorted = &set == &lists(group).near;
  const double rounding = rounding_of_boxes<Scalar>(boxes.place(set, m_surface) + spent);
  boxes.trees.update(boxes.nodes, group, spent + rounding);
  NearQuestion<Scalar> question;
  question.points = boxes.points.front().place.data();
  question.distance = static_cast<Scalar>(spent) * (Scalar(1) + std::numeric_limits<Scalar>::epsilon());
  question.enough = static_cast<Scalar>(ENOUGH * set.distance);
  question.rounding = static_cast<Scalar>(rounding) * (Scalar(1) + std::numeric_limits<Scalar>::epsilon());
  const float reach = static_cast<float>(set.distance) * (1.0F + SINGLE_SLACK);
  const auto keep_near = [&](PairKind kind) -> Finish {
    const FindNear<Scalar> find_near =
        kind == PairKind::edge_edge ? boxes.kernels.find_near_edges : boxes.kernels.find_near_triangles;
    return [&, kind, find_near](std::vector<CandidatePair>& pairs, std::size_t begin) {
      std::array<NearAnswer<Scalar>, BLOCK + 1> answers;
      std::size_t kept = begin;
      for (std::size_t first = begin; first < pairs.size(); first += BLOCK) {
        const std::size_t size = std::min(BLOCK, pairs.size() - first);
        const int near = find_near(question, records_of(&pairs[first], size), answers.data());
        for (int i = 0; i < near; ++i) {
          const NearAnswer<Scalar>& answer = answers[static_cast<std::size_t>(i)];
          CandidatePair& pair = pairs[kept] = pairs[first + static_cast<std::size_t>(answer.index)];
          if (answer.apart >= question.enough) {
            pair.apart = static_cast<float>(answer.apart) * (1.0F - SINGLE_SLACK);
            pair.reach = reach;
            ++kept;
            continue;
          }
          measure(kind, group, set, static_cast<double>(answer.apart), pair);
          if (!(pair.apart - spent > answer.approach))
            ++kept;
        }
      }
      pairs.resize(kept);
      if (sorted)
        sort_pairs(pairs, begin);
    };
  };
  const std::size_t triangles = collect(
      m_surface.points().size(), m_most_pairs,
      [&](std::int32_t begin, std::int32_t end, std::vector<CandidatePair>& found) {
        boxes.trees.add_triangles(begin, end, found);
      },
      keep_near(PairKind::point_triangle), set.pairs[static_cast<std::size_t>(PairKind::point_triangle)]);
  const std::size_t room = m_most_pairs - std::min(triangles, m_most_pairs);
  const std::size_t edges =
      triangles > m_most_pairs
          ? 0
          : collect(
                m_surface.edges().size(), room,
                [&](std::int32_t begin, std::int32_t end, std::vector<CandidatePair>& found) {
                  boxes.trees.add_edges(begin, end, found);
                },
                keep_near(PairKind::edge_edge), set.pairs[static_cast<std::size_t>(PairKind::edge_edge)]);
  const bool fits = triangles + edges <= m_most_pairs;
  for (std::vector<CandidatePair>& pairs : set.pairs) {
    if (!fits)
      pairs.clear();
  }
  return fits;
}

/// Boxes of nodes on their ways. Returns the largest coordinate, of a place or a way.
template <class Scalar> double BroadPhase::Boxes<Scalar>::place(const PairSet& set, const Surface& surface) {
  const std::vector<std::int32_t>& of_surface = surface.points();
  Vec3 origin = Vec3::Zero(); // of the scene, so that single precision tells its parts apart wherever it is
  for (const std::int32_t node : of_surface)
    origin += set.from.row(node).transpose() / static_cast<double>(of_surface.size());
  nodes.resize(static_cast<std::size_t>(surface.node_count()));
  points.resize(nodes.size());
  double most = 0.0;
  for (const std::int32_t node : of_surface) {
    Four<Scalar> at = Four<Scalar>::Zero();
    Four<Scalar> way = Four<Scalar>::Zero();
    for (int i = 0; i < 3; ++i) {
      const double x = set.from(node, i) - origin[i];
      at[i] = static_cast<Scalar>(x);
      way[i] = static_cast<Scalar>(set.way(node, i));
      most = std::max({most, std::abs(x), std::abs(set.way(node, i))});
    }
    nodes[static_cast<std::size_t>(node)] = MovingBoxOf<Scalar>::of(at, way);
    points[static_cast<std::size_t>(node)] = {at, way};
  }
  return most;
}

std::size_t BroadPhase::pair_count() const {
  std::size_t count = 0;
  for (const Lists& lists : m_lists) {
    for (const PairSet* set : {&lists.list, &lists.near})
      count += set->pairs[0].size() + set->pairs[1].size();
  }
  return count;
}

std::size_t BroadPhase::memory_bytes() const {
  std::size_t bytes =
      m_boxes.trees.memory_bytes() + m_boxes.nodes.capacity() * (sizeof(MovingBox) + sizeof(MovingPoint<float>));
  if (m_wide_boxes)
    bytes += m_wide_boxes->trees.memory_bytes() + m_wide_boxes->nodes.capacity() * sizeof(WideMovingBox);
  for (const Lists& lists : m_lists) {
    for (const PairSet* set : {&lists.list, &lists.near}) {
      bytes += (set->pairs[0].capacity() + set->pairs[1].capacity()) * sizeof(CandidatePair);
      bytes += static_cast<std::size_t>(set->from.size() + set->way.size() + set->measured_at.size()) * sizeof(double);
    }
  }
  for (const std::vector<CandidatePair>& chunk : m_chunks)
    bytes += chunk.capacity() * sizeof(CandidatePair);
  for (const std::vector<std::int32_t>& moved : m_moved)
    bytes += moved.capacity() * sizeof(std::int32_t);
  return bytes;
}

} // namespace wry::contact
