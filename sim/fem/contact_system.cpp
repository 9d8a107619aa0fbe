#include "sim/fem/contact_system.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "sim/base/stopwatch.h"
#include "sim/contact/pair_boxes.h"

namespace wry::fem {

namespace {

using contact::CandidatePair;
using contact::PairKind;

/// An iteration may not use up more than this leaves of any gap: Newton comes out of a deep barrier slowly.
constexpr double KEPT_SHARE = 0.3;
/// Pairs of one body that are near each other at rest feel each other only below this share of their rest distance.
constexpr double REST_SHARE = 0.5;
/// Ways that bend a body by more rooms than this are not asked for whole: a direction along negative curvature has no
/// length of its own, and its list would be of everything with everything.
constexpr double MOST_ROOMS = 80.0;
/// No barrier becomes stiffer than so many times what was chosen from the scene: beyond, Newton only gets stuck.
constexpr double MOST_STIFFENING = 65536.0;
constexpr std::size_t GRAIN = 2048;

} // namespace

std::size_t ContactSystem::slot(int a, int b) const {
  return static_cast<std::size_t>(std::min(a, b)) * static_cast<std::size_t>(m_surface.part_count()) +
         static_cast<std::size_t>(std::max(a, b));
}

void ContactSystem::stiffen(std::size_t slot, double factor) {
  m_stiffness[slot] = std::min(factor * m_stiffness[slot], MOST_STIFFENING * m_least_stiffness[slot]);
}

std::string ContactSystem::part_name(int part) const {
  const std::size_t bodies = m_scene.model.bodies.size();
  const std::size_t index = static_cast<std::size_t>(part);
  return index < bodies ? fmt::format("body '{}'", m_scene.model.bodies[index].name)
                        : fmt::format("collider '{}'", m_obstacles[index - bodies].collider->name);
}

void ContactSystem::pose_obstacles(double time, Points& out) const {
  out.resize(m_surface.node_count() - m_unknown_nodes, 3);
  for (const Obstacle& obstacle : m_obstacles) {
    const scene::Pose pose = obstacle.collider->motion.pose(time);
    const scene::MeshSequence* sequence = obstacle.collider->sequence();
    const Points local = sequence != nullptr ? sequence->at(time) : Points();
    const Points& vertices = sequence != nullptr ? local : obstacle.rest;
    for (Eigen::Index i = 0; i < vertices.rows(); ++i)
      out.row(obstacle.first_node - m_unknown_nodes + i) = pose.apply(vertices.row(i).transpose()).transpose();
  }
}

void ContactSystem::place_obstacles(double time) {
  pose_obstacles(time, m_obstacle_start);
  m_obstacle_end = m_obstacle_start;
  m_obstacle_share = 1.0;
  m_all.bottomRows(m_obstacle_start.rows()) = m_obstacle_start;
  m_pairs_at.resize(0, 3);
}

void ContactSystem::begin_step(double start_time, double end_time) {
  m_last_limit = {};
  if (m_obstacles.empty())
    return;
  place_obstacles(start_time);
  const bool moves = std::any_of(m_obstacles.begin(), m_obstacles.end(),
                                 [](const Obstacle& obstacle) { return obstacle.collider->moves(); });
  if (!moves)
    return;
  pose_obstacles(end_time, m_obstacle_end);
  m_obstacle_share = m_obstacle_end == m_obstacle_start ? 1.0 : 0.0;
}

void ContactSystem::expect_ways(const Points& ways) {
  Points all(m_surface.node_count(), 3);
  all.topRows(m_unknown_nodes) = ways;
  all.bottomRows(m_obstacle_start.rows()) = m_obstacle_end - m_obstacle_start;
  m_broad_phase->expect_ways(std::move(all));
}

double ContactSystem::advance_obstacles(const Points& positions) {
  if (m_obstacle_share >= 1.0)
    return 0.0;
  m_from = all_positions(positions);
  m_to = m_from;
  m_to.bottomRows(m_obstacle_end.rows()) = m_obstacle_end;
  const double safe = safe_fraction(m_from, m_to);
  m_obstacle_share = safe >= 1.0 ? 1.0 : m_obstacle_share + safe * (1.0 - m_obstacle_share);
  m_all.bottomRows(m_obstacle_end.rows()) =
      m_obstacle_share >= 1.0 ? m_obstacle_end
                              : Points(m_obstacle_start + m_obstacle_share * (m_obstacle_end - m_obstacle_start));
  m_pairs_at.resize(0, 3);
  return 1.0 - m_obstacle_share;
}

const Points& ContactSystem::all_positions(const Points& positions) {
  m_all.topRows(m_unknown_nodes) = positions;
  return m_all;
}

double ContactSystem::rest_limit(PairKind kind, const std::array<std::int32_t, 4>& nodes) const {
  return REST_SHARE * std::sqrt(contact::squared_distance(kind, contact::gather(m_rest, nodes)));
}

/// Within a part that is near itself at rest, at most half of what is left there, so that a gap remains.
double ContactSystem::thickness_of(PairKind kind, const std::array<std::int32_t, 4>& nodes) const {
  const int a = m_surface.part_of_node(nodes[0]);
  const int b = m_surface.part_of_node(nodes[3]);
  const double whole = m_half_thickness[static_cast<std::size_t>(a)] + m_half_thickness[static_cast<std::size_t>(b)];
  return a == b && whole > 0.0 ? std::min(whole, 0.5 * rest_limit(kind, nodes)) : whole;
}

const std::vector<ContactPair>& ContactSystem::pairs_at(const Points& positions) {
  if (m_pairs_at.rows() == positions.rows() && m_pairs_at == positions)
    return m_pairs;
  const Stopwatch watch(m_cost.search_ms);
  all_positions(positions);
  // Without room to move the lists are as short as they can be: what does not fit then is no scene to simulate.
  if (!m_broad_phase->cover(m_all, m_all, m_distance + m_most_thickness, m_room))
    m_broad_phase->cover(m_all, m_all, m_distance + m_most_thickness, 0.0);
  update_pairs();
  m_pairs_at = positions;
  return m_pairs;
}

void ContactSystem::update_pairs() {
  m_pairs.clear();
  for (const contact::PairGroup group : contact::PAIR_GROUPS) {
    if (m_broad_phase->pairs(group, PairKind::point_triangle).empty() &&
        m_broad_phase->pairs(group, PairKind::edge_edge).empty())
      continue;
    m_broad_phase->measure_ways(group, m_all, m_all, m_since_measured);
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge})
      add_near_pairs(group, kind);
  }
}

void ContactSystem::add_near_pairs(contact::PairGroup group, PairKind kind) {
  const std::vector<CandidatePair>& candidates = m_broad_phase->pairs(group, kind);
  const std::size_t chunk_count = (candidates.size() + GRAIN - 1) / GRAIN;
  m_chunks.resize(std::max(m_chunks.size(), chunk_count));
  m_threads.for_chunks(candidates.size(), GRAIN, [&](std::size_t begin, std::size_t end) {
    std::vector<ContactPair>& out = m_chunks[begin / GRAIN];
    out.clear();
    std::vector<std::int32_t> in_reach;
    m_since_measured.find_in_reach(kind, candidates, begin, end, in_reach);
    for (const std::int32_t i : in_reach) {
      const CandidatePair& candidate = candidates[static_cast<std::size_t>(i)];
      const double reach = candidate.reach;
      if (contact::squared_box_distance(kind, m_all, candidate.nodes) >= reach * reach)
        continue;
      const double squared = contact::squared_distance(kind, contact::gather(m_all, candidate.nodes));
      if (squared >= reach * reach)
        continue;
      ContactPair pair{kind, candidate.nodes, {}, m_distance, thickness_of(kind, candidate.nodes), 0.0};
      pair.parts[0] = m_surface.part_of_node(candidate.nodes[0]);
      pair.parts[1] = m_surface.part_of_node(candidate.nodes[3]);
      if (group == contact::PairGroup::within_parts)
        pair.activation = std::min(m_distance, rest_limit(kind, candidate.nodes) - pair.thickness);
      const double felt = pair.activation + pair.thickness;
      if (squared >= felt * felt)
        continue;
      if (kind == PairKind::edge_edge)
        pair.mollifier_threshold =
            contact::mollifier_threshold(m_edge_squares[candidate.first], m_edge_squares[candidate.second]);
      out.push_back(pair);
    }
  });
  for (std::size_t chunk = 0; chunk < chunk_count; ++chunk)
    m_pairs.insert(m_pairs.end(), m_chunks[chunk].begin(), m_chunks[chunk].end());
}

contact::PairPoints ContactSystem::points_of(const ContactPair& pair) const {
  return contact::gather(m_all, pair.nodes);
}

contact::PairPoints ContactSystem::way_of(const ContactPair& pair, const Points& positions,
                                          const Points& start_positions) const {
  contact::PairPoints way;
  for (int k = 0; k < 4; ++k) {
    const std::int32_t node = pair.nodes[static_cast<std::size_t>(k)];
    if (is_unknown(node))
      way.row(k) = positions.row(node) - start_positions.row(node);
    else
      way.row(k) = m_all.row(node) - m_obstacle_start.row(node - m_unknown_nodes);
  }
  return way;
}

double ContactSystem::step_limit(const Points& positions, const Points& change) {
  m_from = all_positions(positions);
  m_to = m_from;
  m_to.topRows(m_unknown_nodes) += change;
  return safe_fraction(m_from, m_to);
}

double ContactSystem::safe_fraction(const Points& from, const Points& to) {
  const double way = m_broad_phase->longest_way_within(from, to);
  double part = way > MOST_ROOMS * m_room ? MOST_ROOMS * m_room / way : 1.0;
  Points end = part < 1.0 ? Points(from + part * (to - from)) : to;
  {
    const Stopwatch watch(m_cost.search_ms);
    while (!m_broad_phase->cover(from, end, m_distance + m_most_thickness, m_room)) {
      part *= 0.5; // too many pairs come into reach: go a shorter way
      end = from + part * (to - from);
      if (part < 1e-6)
        return 0.0;
    }
  }
  const Stopwatch watch(m_cost.safe_step_ms);
  const double rounding = ROUNDING_UNITS * std::numeric_limits<double>::epsilon() *
                          std::max(from.cwiseAbs().maxCoeff(), end.cwiseAbs().maxCoeff());
  contact::KeptDistance keep{KEPT_SHARE, m_distance, rounding};
  if (m_most_thickness > 0.0) {
    keep.most_thickness = m_most_thickness;
    keep.thickness = [this](PairKind kind, const std::array<std::int32_t, 4>& nodes) {
      return thickness_of(kind, nodes);
    };
  }
  const contact::SafeStep step = contact::find_safe_step(*m_broad_phase, from, end, keep, m_ccd, m_threads);
  if (step.nodes[0] >= 0)
    m_last_limit = step;
  return part * step.fraction;
}

bool ContactSystem::any_friction() const {
  return std::any_of(m_friction.begin(), m_friction.end(),
                     [](const Friction& friction) { return friction.at_rest > 0.0 || friction.sliding > 0.0; });
}

ContactSystem::Gaps ContactSystem::measure(const Points& positions) {
  Gaps gaps;
  gaps.least = std::numeric_limits<double>::infinity();
  for (const ContactPair& pair : pairs_at(positions)) {
    gaps.least =
        std::min(gaps.least, std::sqrt(contact::squared_distance(pair.kind, points_of(pair))) - pair.thickness);
    ++gaps.active;
  }
  return gaps;
}

void ContactSystem::stiffen_crowded(const Points& positions, double share, double factor) {
  std::set<std::size_t> crowded;
  for (const ContactPair& pair : pairs_at(positions)) {
    const double limit = pair.thickness + share * pair.activation;
    if (contact::squared_distance(pair.kind, points_of(pair)) < limit * limit)
      crowded.insert(slot(pair.parts[0], pair.parts[1]));
  }
  for (const std::size_t index : crowded)
    stiffen(index, factor);
}

void ContactSystem::stiffen_limiting(double factor) {
  if (m_last_limit.nodes[0] >= 0)
    stiffen(slot(m_surface.part_of_node(m_last_limit.nodes[0]), m_surface.part_of_node(m_last_limit.nodes[3])), factor);
}

std::string ContactSystem::describe_limit() const {
  if (m_last_limit.nodes[0] < 0)
    return {};
  const bool edges = m_last_limit.kind == PairKind::edge_edge;
  const Vec3 at = m_all.row(m_last_limit.nodes[0]);
  return fmt::format("the nearest {} are of {} and {}, near ({:.6g}, {:.6g}, {:.6g})",
                     edges ? "edges" : "point and triangle", part_name(m_surface.part_of_node(m_last_limit.nodes[0])),
                     part_name(m_surface.part_of_node(m_last_limit.nodes[3])), at.x(), at.y(), at.z());
}

ContactSystem::Cost ContactSystem::take_cost() {
  const Cost cost = m_cost;
  m_cost = {};
  return cost;
}

std::size_t ContactSystem::candidate_count() const {
  return m_broad_phase->pair_count();
}

std::size_t ContactSystem::memory_bytes() const {
  return m_broad_phase->memory_bytes() + m_pairs.capacity() * sizeof(ContactPair) +
         static_cast<std::size_t>(m_all.size()) * 8 * sizeof(double);
}

} // namespace wry::fem
