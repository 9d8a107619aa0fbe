#include "sim/contact/broad_phase.h"

#include <cmath>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "sim/contact/crossings.h"
#include "sim/contact/distance.h"
#include "sim/contact/safe_step.h"

namespace wry::contact {
namespace {

/// Wavy sheets of 2 x n x n triangles above each other, each a part.
struct Sheets {
  Surface surface;
  Points positions;

  explicit Sheets(int count, int n = 8) {
    positions.resize(count * (n + 1) * (n + 1), 3);
    std::vector<Surface::Triangle> triangles;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const int a = i * (n + 1) + j;
        triangles.push_back({a, a + 1, a + n + 1});
        triangles.push_back({a + 1, a + n + 2, a + n + 1});
      }
    }
    for (int sheet = 0; sheet < count; ++sheet) {
      surface.add_part((n + 1) * (n + 1), triangles);
      for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n; ++j)
          positions.row((sheet * (n + 1) + i) * (n + 1) + j) << 0.1 * i + 0.03 * sheet,
              0.1 * sheet + 0.03 * std::sin(2.1 * i + 1.3 * j + sheet), 0.1 * j;
      }
    }
    for (int a = 0; a < count; ++a) {
      for (int b = 0; b <= a; ++b)
        surface.let_meet(a, b);
    }
  }
};

template <class Primitive> bool has_node(const Primitive& primitive, std::int32_t node) {
  return std::find(primitive.begin(), primitive.end(), node) != primitive.end();
}

/// All pairs that can touch at all, by looking at each: what the search has to agree with.
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

using Key = std::pair<std::int32_t, std::int32_t>;

std::vector<CandidatePair> pairs_of(const BroadPhase& broad, PairKind kind) {
  std::vector<CandidatePair> pairs = broad.pairs(PairGroup::between_parts, kind);
  const std::vector<CandidatePair>& within = broad.pairs(PairGroup::within_parts, kind);
  pairs.insert(pairs.end(), within.begin(), within.end());
  return pairs;
}

std::set<Key> near_pairs(const std::vector<CandidatePair>& pairs, PairKind kind, const Points& x, double distance) {
  std::set<Key> near;
  for (const CandidatePair& pair : pairs) {
    PairPoints points;
    for (int k = 0; k < 4; ++k)
      points.row(k) = x.row(pair.nodes[static_cast<std::size_t>(k)]);
    if (squared_distance(kind, points) < distance * distance)
      near.insert({pair.first, pair.second});
  }
  return near;
}

TEST(BroadPhase, FindsEveryPairThatIsNearAnywhereOnTheWay) {
  const Sheets sheets(3);
  const Threads threads(1);
  Points to = sheets.positions;
  for (Eigen::Index i = 0; i < to.rows(); ++i)
    to.row(i) += Eigen::RowVector3d(0.02 * std::sin(i), -0.05 * std::cos(3.0 * i), 0.03 * std::sin(2.0 * i));
  BroadPhase broad(sheets.surface, threads, 1'000'000);
  ASSERT_TRUE(broad.cover(sheets.positions, to, 0.1, 0.001));
  for (const double t : {0.0, 0.3, 0.7, 1.0}) {
    const Points at = (1.0 - t) * sheets.positions + t * to;
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
      const std::set<Key> all = near_pairs(all_pairs(sheets.surface, kind), kind, at, 0.1);
      EXPECT_GT(all.size(), 10u);
      EXPECT_EQ(near_pairs(pairs_of(broad, kind), kind, at, 0.1), all);
    }
  }
  EXPECT_LT(pairs_of(broad, PairKind::edge_edge).size(), all_pairs(sheets.surface, PairKind::edge_edge).size() / 4);
}

TEST(BroadPhase, FindsThemAlsoWhenNodesAreUnequallyFarAlongTheirWays) {
  const Sheets sheets(3);
  const Threads threads(1);
  Points to = sheets.positions;
  to.col(1).array() -= 0.09;
  BroadPhase broad(sheets.surface, threads, 1'000'000);
  ASSERT_TRUE(broad.cover(sheets.positions, to, 0.02, 0.1));
  ASSERT_EQ(broad.searches(), 1);
  // Inside all rooms, but sheets are not where they would be by going along together.
  Points mixed = sheets.positions;
  mixed.middleRows(81, 81) = to.middleRows(81, 81);
  ASSERT_TRUE(broad.cover(mixed, mixed, 0.02, 0.1));
  EXPECT_EQ(broad.searches(), 1);
  for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
    const std::set<Key> all = near_pairs(all_pairs(sheets.surface, kind), kind, mixed, 0.02);
    EXPECT_GT(all.size(), 10u);
    EXPECT_EQ(near_pairs(pairs_of(broad, kind), kind, mixed, 0.02), all);
  }
}

TEST(BroadPhase, IsReusedWhileNodesKeepTheirRooms) {
  const Sheets sheets(2);
  const Threads threads(1);
  BroadPhase broad(sheets.surface, threads, 1'000'000);
  ASSERT_TRUE(broad.cover(sheets.positions, sheets.positions, 0.02, 0.01));
  Points moved = sheets.positions;
  moved.array() += 0.005;
  ASSERT_TRUE(broad.cover(sheets.positions, moved, 0.02, 0.01));
  EXPECT_EQ(broad.searches(), 1);
  moved(5, 1) += 0.012;
  ASSERT_TRUE(broad.cover(moved, moved, 0.02, 0.01));
  EXPECT_EQ(broad.searches(), 2);
}

TEST(BroadPhase, PartsThatGoFarTogetherMeetNoMoreThanAtRest) {
  const Sheets sheets(2);
  const Threads threads(1);
  Points a_little = sheets.positions;
  a_little.array() += 0.05; // just enough to be searched for in the same way
  Points far = sheets.positions;
  far.array() += 0.5;
  BroadPhase rest(sheets.surface, threads, 1'000'000);
  BroadPhase moved(sheets.surface, threads, 1'000'000);
  const double little_more = 1e-4; // so that single precision cannot decide
  ASSERT_TRUE(rest.cover(sheets.positions, a_little, 0.1 + little_more, 0.01));
  ASSERT_TRUE(moved.cover(sheets.positions, far, 0.1, 0.01));
  for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
    EXPECT_GT(pairs_of(moved, kind).size(), 10u);
    EXPECT_LE(pairs_of(moved, kind).size(), pairs_of(rest, kind).size());
  }
}

TEST(BroadPhase, PairsOfAListWithNarrowRoomsHoldInTheseOnly) {
  const Sheets sheets(3);
  const Threads threads(1);
  Points moved = sheets.positions;
  moved.middleRows(81, 81).col(1).array() -= 0.04; // less than the small balls
  BroadPhase broad(sheets.surface, threads, 1'000'000);
  ASSERT_TRUE(broad.cover(sheets.positions, sheets.positions, 0.1, 0.0));
  ASSERT_TRUE(broad.cover(moved, moved, 0.1, 0.0));
  for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
    EXPECT_EQ(near_pairs(pairs_of(broad, kind), kind, moved, 0.1),
              near_pairs(all_pairs(sheets.surface, kind), kind, moved, 0.1));
  }
}

TEST(BroadPhase, FindsEveryPairOfASheetThatTumbles) {
  Sheets sheets(1, 16);
  sheets.positions.col(1) *= 4.0; // folds come near each other
  const Threads threads(1);
  const Points to =
      sheets.positions * Eigen::AngleAxisd(1.0, Vec3(0.3, 0.4, 0.5).normalized()).toRotationMatrix().transpose();
  BroadPhase broad(sheets.surface, threads, 1'000'000);
  ASSERT_TRUE(broad.cover(sheets.positions, to, 0.02, 0.001));
  for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const Points at = (1.0 - t) * sheets.positions + t * to;
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
      const std::set<Key> all = near_pairs(all_pairs(sheets.surface, kind), kind, at, 0.02);
      EXPECT_EQ(near_pairs(pairs_of(broad, kind), kind, at, 0.02), all);
    }
  }
  EXPECT_GT(pairs_of(broad, PairKind::edge_edge).size(), 10u);
  EXPECT_LT(pairs_of(broad, PairKind::edge_edge).size(), all_pairs(sheets.surface, PairKind::edge_edge).size() / 10);
}

TEST(BroadPhase, FindsLongWaysAlsoWhereSinglePrecisionTellsNothing) {
  Sheets sheets(3);
  sheets.positions.bottomRows(81).array() += 1e8; // single precision has steps of four metres there
  const Threads threads(1);
  Points to = sheets.positions;
  to.topRows(81).col(1).array() += 0.07;
  BroadPhase broad(sheets.surface, threads, 10'000);
  ASSERT_TRUE(broad.cover(sheets.positions, to, 0.02, 0.001));
  for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
    const std::set<Key> all = near_pairs(all_pairs(sheets.surface, kind), kind, to, 0.02);
    EXPECT_GT(all.size(), 10u);
    EXPECT_EQ(near_pairs(pairs_of(broad, kind), kind, to, 0.02), all);
  }
}

TEST(BroadPhase, KeepsTheListOfABodyThatFlies) {
  Sheets sheets(2);
  Surface alone;
  alone.add_part(81, {sheets.surface.triangles().begin(), sheets.surface.triangles().begin() + 128});
  alone.let_meet(0, 0);
  const Threads threads(1);
  BroadPhase broad(alone, threads, 1'000'000);
  Points start = sheets.positions.topRows(81);
  ASSERT_TRUE(broad.cover(start, start, 0.1, 0.01));
  const std::size_t pairs = broad.pair_count();
  EXPECT_GT(pairs, 0u);
  Points flown = start;
  flown.rowwise() += Eigen::RowVector3d(40.0, -3.0, 7.0);
  ASSERT_TRUE(broad.cover(start, flown, 0.1, 0.01));
  EXPECT_EQ(broad.searches(), 1);
  flown(40, 1) += 0.1; // and folds: now the list does not hold
  ASSERT_TRUE(broad.cover(flown, flown, 0.1, 0.01));
  EXPECT_EQ(broad.searches(), 2);
}

void expect_all_near(const BroadPhase& broad, const Sheets& sheets, const Points& at, double distance,
                     std::size_t& count) {
  for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
    const std::set<Key> all = near_pairs(all_pairs(sheets.surface, kind), kind, at, distance);
    EXPECT_EQ(near_pairs(pairs_of(broad, kind), kind, at, distance), all);
    count += all.size();
  }
}

TEST(BroadPhase, AListMadeAlongTheExpectedWaysServesTheStepsToCome) {
  const Sheets sheets(3);
  const Threads threads(1);
  Points step = Points::Zero(sheets.positions.rows(), 3);
  step.middleRows(81, 81).col(1).array() -= 0.011;
  Points correction = 0.001 * Points::Ones(step.rows(), 3);
  correction.topRows(81) *= -1.0;
  BroadPhase blind(sheets.surface, threads, 1'000'000);
  BroadPhase seeing(sheets.surface, threads, 1'000'000);
  seeing.expect_ways(step);
  std::size_t count = 0;
  for (int i = 0; i < 5; ++i) {
    const Points from = sheets.positions + i * step + correction;
    for (BroadPhase* broad : {&blind, &seeing}) {
      ASSERT_TRUE(broad->cover(from, from - correction, 0.06, 0.01));
      expect_all_near(*broad, sheets, from - 0.5 * correction, 0.06, count);
    }
  }
  EXPECT_GT(count, 100u);
  EXPECT_EQ(seeing.searches(), 1);
  EXPECT_GT(blind.searches(), 1);
}

TEST(BroadPhase, MissesNoPairOnAWalkOfStepsAndCorrections) {
  Sheets sheets(2, 6);
  const Threads threads(1);
  BroadPhase broad(sheets.surface, threads, 1'000'000);
  Points x = sheets.positions;
  std::size_t count = 0;
  for (int i = 0; i < 60; ++i) {
    Points way(x.rows(), 3);
    for (Eigen::Index node = 0; node < x.rows(); ++node) {
      const double phase = 0.7 * static_cast<double>(node) + 0.3 * i;
      const Eigen::RowVector3d shake(std::sin(phase), std::cos(1.3 * phase), std::sin(2.1 * phase));
      way.row(node) = 0.002 * shake + Eigen::RowVector3d(0.01, node < 49 ? 0.002 : -0.003, 0.0);
    }
    if (i % 3 == 1)
      way *= 0.1; // as a correction of Newton's
    if (i % 7 == 0)
      broad.expect_ways(i % 2 == 0 ? Points(-way) : way);
    const Points to = x + way;
    ASSERT_TRUE(broad.cover(x, to, 0.03, 0.01));
    for (const double t : {0.0, 0.4, 1.0})
      expect_all_near(broad, sheets, (1.0 - t) * x + t * to, 0.03, count);
    x = to;
  }
  EXPECT_GT(count, 1000u);
  EXPECT_LT(broad.searches(), 40);
}

TEST(BroadPhase, IsTheSameOnAnyNumberOfThreads) {
  const Sheets sheets(4, 16);
  const Threads one(1);
  const Threads three(3);
  BroadPhase a(sheets.surface, one, 1'000'000);
  BroadPhase b(sheets.surface, three, 1'000'000);
  ASSERT_TRUE(a.cover(sheets.positions, sheets.positions, 0.05, 0.0));
  ASSERT_TRUE(b.cover(sheets.positions, sheets.positions, 0.05, 0.0));
  const std::vector<CandidatePair> of_a = pairs_of(a, PairKind::edge_edge);
  const std::vector<CandidatePair> of_b = pairs_of(b, PairKind::edge_edge);
  ASSERT_EQ(of_a.size(), of_b.size());
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    ASSERT_EQ(of_a[i].nodes, of_b[i].nodes);
    ASSERT_EQ(of_a[i].apart, of_b[i].apart);
  }
}

TEST(BroadPhase, RefusesMorePairsThanItsRoomInsteadOfFillingTheMemory) {
  const Sheets sheets(3);
  const Threads threads(1);
  BroadPhase broad(sheets.surface, threads, 20'000);
  EXPECT_FALSE(broad.cover(sheets.positions, sheets.positions, 10.0, 0.0));
  EXPECT_EQ(broad.pair_count(), 0u);
  EXPECT_TRUE(broad.cover(sheets.positions, sheets.positions, 1e-4, 0.0));
}

TEST(BroadPhase, PartsThatMayNotMeetAreNoCandidates) {
  Sheets sheets(2);
  Surface apart;
  std::vector<Surface::Triangle> triangles(sheets.surface.triangles().begin(),
                                           sheets.surface.triangles().begin() + 128);
  apart.add_part(81, triangles);
  apart.add_part(81, triangles);
  const Threads threads(1);
  BroadPhase broad(apart, threads, 1'000'000);
  ASSERT_TRUE(broad.cover(sheets.positions, sheets.positions, 1.0, 0.0));
  EXPECT_EQ(broad.pair_count(), 0u);
}

TEST(SafeStep, StopsASheetBeforeItPassesAnotherAtAnySpeed) {
  const Sheets sheets(2);
  const Threads threads(1);
  for (const double fall : {0.2, 1.0, 100.0}) {
    Points to = sheets.positions;
    to.bottomRows(81).col(1).array() -= fall;
    BroadPhase broad(sheets.surface, threads, 10'000'000);
    ASSERT_TRUE(broad.cover(sheets.positions, to, 0.01, 0.0));
    const SafeStep step =
        find_safe_step(broad, sheets.positions, to, {0.1, 0.01, 0.0}, select_ccd(native_isa()), threads);
    ASSERT_LT(step.fraction, 1.0) << fall;
    ASSERT_GT(step.fraction, 0.0);
    const Points at = sheets.positions + step.fraction * (to - sheets.positions);
    EXPECT_TRUE(find_crossings(sheets.surface, at, threads).empty());
    // Not far from the touch: a little further they would cross.
    const Points beyond = sheets.positions + (step.fraction + 0.02 / fall) * (to - sheets.positions);
    EXPECT_FALSE(find_crossings(sheets.surface, beyond, threads).empty()) << fall;
  }
}

TEST(Crossings, NameTheEdgeAndTheTriangleThatCut) {
  Sheets sheets(2);
  const Threads threads(1);
  EXPECT_TRUE(find_crossings(sheets.surface, sheets.positions, threads).empty());
  sheets.positions(81 + 40, 1) = -0.2; // one node pulled down through the other sheet
  const std::vector<Crossing> found = find_crossings(sheets.surface, sheets.positions, threads);
  ASSERT_FALSE(found.empty());
  bool named = false;
  for (const Crossing& crossing : found)
    named = named || crossing.edge[0] == 121 || crossing.edge[1] == 121;
  EXPECT_TRUE(named);
}

} // namespace
} // namespace wry::contact
