#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "sim/contact/box_tree.h"
#include "sim/contact/candidate_pair.h"
#include "sim/contact/distance.h"
#include "sim/contact/moving_box.h"
#include "sim/contact/select_search.h"
#include "sim/contact/ways.h"
#include "tests/runnable_isas.h"

namespace wry::contact {
namespace {

template <class T> const SearchKernels<T>& kernels_of(const SearchTable& table) {
  if constexpr (sizeof(T) == sizeof(float))
    return table.single;
  else
    return table.wide;
}

template <class T> class SearchKernel : public testing::Test {
protected:
  Four<T> triple(double least, double most) {
    std::uniform_real_distribution<T> number(static_cast<T>(least), static_cast<T>(most));
    return {number(random), number(random), number(random), T(0)};
  }
  std::mt19937 random{11};
};
using Numbers = testing::Types<float, double>;
TYPED_TEST_SUITE(SearchKernel, Numbers);

/// Groups of one to all boxes, on lists whose trees are one leaf or many levels, with room for the hits of a leaf only
/// or for all.
TYPED_TEST(SearchKernel, FindsInATreeWhatEachBoxMeets) {
  using T = TypeParam;
  std::size_t hits_of_all = 0;
  for (const Isa isa : test::runnable_isas()) {
    const FindInTree<T> find = kernels_of<T>(select_search(isa)).find_in_tree;
    for (const std::size_t size : {1U, 3U, 4U, 5U, 17U, 300U, 2000U}) {
      std::vector<MovingBoxOf<T>> boxes;
      for (std::size_t i = 0; i < size; ++i) {
        const Four<T> low = this->triple(0.0, 1.0), way = this->triple(-0.2, 0.2);
        boxes.push_back({low, low + this->triple(0.0, 0.1), way, way + this->triple(0.0, 0.05)});
      }
      TreeOf<MovingBoxOf<T>> tree;
      tree.build(boxes);
      for (int count = 1; count <= MOST_ASKERS; ++count) {
        TreeQuery<T> query;
        for (MovingBoxes<T>& pack : query.boxes)
          clear(pack);
        std::vector<std::size_t> asking;
        MovingBoxOf<T> around;
        for (; query.count < count; ++query.count) {
          asking.push_back(this->random() % size);
          const MovingBoxOf<T>& box = boxes[asking.back()];
          put(query.boxes[query.count / 4], query.count % 4, box);
          query.after[query.count] = static_cast<std::int32_t>(this->random() % size) - 1;
          if (query.count == 0)
            around = box;
          around.include(box);
        }
        for (int i = 0; i < 3; ++i) {
          query.low[i] = around.low[i];
          query.high[i] = around.high[i];
          query.way_low[i] = around.way_low[i];
          query.way_high[i] = around.way_high[i];
        }
        std::set<std::pair<std::int32_t, std::int32_t>> expected, found;
        for (std::int32_t which = 0; which < count; ++which) {
          for (std::int32_t j = query.after[which] + 1; j < static_cast<std::int32_t>(size); ++j) {
            if (boxes[asking[static_cast<std::size_t>(which)]].meets(boxes[static_cast<std::size_t>(j)]))
              expected.insert({which, j});
          }
        }
        for (const int room : {HITS_OF_LEAF, 4 * static_cast<int>(size) * MOST_ASKERS + HITS_OF_LEAF}) {
          found.clear();
          std::vector<TreeHit> hits(static_cast<std::size_t>(room));
          TreeWalk walk(tree.nodes().front().is_leaf);
          int rounds = 0;
          for (; !walk.is_over(); ++rounds) {
            const int some = find(tree.nodes().data(), query, walk, hits.data(), room);
            for (int i = 0; i < some; ++i)
              EXPECT_TRUE(
                  found.insert({hits[static_cast<std::size_t>(i)].which, hits[static_cast<std::size_t>(i)].index})
                      .second);
          }
          EXPECT_EQ(found, expected) << isa_name(isa) << " " << size << " " << count;
          EXPECT_TRUE(room == HITS_OF_LEAF || rounds == 1);
        }
        hits_of_all += expected.size();
      }
    }
  }
  EXPECT_GT(hits_of_all, 1000U);
}

/// Pairs whose points are near each other and go ways as long; every fifth pair goes along with itself.
TYPED_TEST(SearchKernel, LeavesOutNoPairThatComesNearAndTellsNoGapThatIsTooLarge) {
  using T = TypeParam;
  constexpr int PAIRS = 701; // no multiple of a register
  const double rounding = rounding_of_boxes<T>(1.0);
  for (const Isa isa : test::runnable_isas()) {
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
      for (const double distance : {1e-3, 0.1, 0.6}) {
        std::vector<MovingPoint<T>> points;
        std::vector<CandidatePair> pairs;
        for (int i = 0; i < PAIRS; ++i) {
          CandidatePair pair{};
          const Four<T> flight = this->triple(-1.0, 1.0);
          for (std::size_t k = 0; k < 4; ++k) {
            pair.nodes[k] = static_cast<std::int32_t>(points.size());
            points.push_back({this->triple(-1.0, 1.0), i % 5 == 0 ? flight : Four<T>(this->triple(-0.5, 0.5))});
          }
          pairs.push_back(pair);
        }
        const auto distance_at = [&](int pair, double time) {
          PairPoints at;
          for (int k = 0; k < 4; ++k) {
            const MovingPoint<T>& point = points[4 * static_cast<std::size_t>(pair) + static_cast<std::size_t>(k)];
            at.row(k) =
                (point.place.template cast<double>() + time * point.way.template cast<double>()).template head<3>();
          }
          return std::sqrt(squared_distance(kind, at));
        };
        NearQuestion<T> question;
        question.points = points.front().place.data();
        question.distance = static_cast<T>(distance);
        question.enough = static_cast<T>(2.0 * distance);
        question.rounding = static_cast<T>(rounding);
        const SearchKernels<T> kernels = kernels_of<T>(select_search(isa));
        std::vector<NearAnswer<T>> answers(PAIRS + 1);
        const int found = (kind == PairKind::edge_edge ? kernels.find_near_edges : kernels.find_near_triangles)(
            question, records_of(pairs.data(), pairs.size()), answers.data());
        std::set<int> left;
        int told = 0;
        for (int i = 0; i < found; ++i) {
          const NearAnswer<T>& answer = answers[static_cast<std::size_t>(i)];
          EXPECT_TRUE(left.insert(answer.index).second);
          EXPECT_LE(answer.apart, distance_at(answer.index, 0.0));
          told += answer.apart > T(0) ? 1 : 0;
          for (const double time : {0.3, 0.7, 1.0})
            EXPECT_LE(distance_at(answer.index, 0.0) - distance_at(answer.index, time), answer.approach);
        }
        int near = 0;
        for (int pair = 0; pair < PAIRS; ++pair) {
          double least = distance_at(pair, 0.0);
          for (int step = 1; step <= 32; ++step)
            least = std::min(least, distance_at(pair, step / 32.0));
          if (least <= distance) {
            ++near;
            EXPECT_TRUE(left.contains(pair)) << isa_name(isa) << " " << pair;
          }
        }
        EXPECT_GT(near, distance > 0.01 ? 20 : 0);
        EXPECT_LT(found, PAIRS * 95 / 100);
        EXPECT_GT(told, found / 10);
      }
    }
  }
}

/// Against the largest difference of ways in doubles, at one place and at two.
TEST(Ways, TellWhichPairsHaveComeNearerThanTheyWereApart) {
  constexpr int NODES = 60, PAIRS = 533;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  Surface surface;
  std::vector<Surface::Triangle> triangles;
  for (std::int32_t i = 0; i + 2 < NODES; ++i)
    triangles.push_back({i, i + 1, i + 2});
  surface.add_part(NODES, triangles);
  const auto places = [&](double scale) {
    Points points(NODES, 3);
    for (Eigen::Index i = 0; i < points.size(); ++i)
      points.data()[i] = scale * number(random);
    return points;
  };
  const Points since = places(1.0);
  const Points first = since + places(0.2), second = since + places(0.3);
  const Points middles = Points::Zero(1, 3);
  Points flown = Points::Zero(1, 3);
  flown << 0.05, -0.02, 0.01;
  for (const Isa isa : test::runnable_isas()) {
    const SearchTable kernels = select_search(isa);
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
      std::vector<CandidatePair> pairs;
      for (int i = 0; i < PAIRS; ++i) {
        CandidatePair pair{};
        for (std::int32_t& node : pair.nodes)
          node = static_cast<std::int32_t>(random() % NODES);
        pair.apart = static_cast<float>(0.8 * std::abs(number(random)));
        pair.reach = static_cast<float>(0.2 * std::abs(number(random)));
        pairs.push_back(pair);
      }
      const auto nearer = [&](const CandidatePair& pair, const Points& at) {
        double most = 0.0;
        const int beyond = kind == PairKind::edge_edge ? 2 : 1;
        for (int a = 0; a < beyond; ++a) {
          for (int b = beyond; b < 4; ++b) {
            const std::int32_t p = pair.nodes[static_cast<std::size_t>(a)], q = pair.nodes[static_cast<std::size_t>(b)];
            most = std::max(most, (at.row(p) - since.row(p) - at.row(q) + since.row(q)).norm());
          }
        }
        return most;
      };
      for (const bool both : {false, true}) {
        Ways ways;
        const Placed at{first, flown};
        if (both)
          ways.measure(surface, kernels, {since, middles}, at, {second, flown});
        else
          ways.measure(surface, kernels, {since, middles}, at, at);
        for (const double taken : {0.0, 0.15, -1.0}) {
          std::vector<std::int32_t> moved;
          constexpr std::size_t BEGIN = 7;
          if (taken < 0.0)
            ways.find_in_reach(kind, pairs, BEGIN, PAIRS, moved);
          else
            ways.find_moved(kind, pairs, BEGIN, PAIRS, taken, moved);
          EXPECT_TRUE(std::is_sorted(moved.begin(), moved.end()));
          const std::set<std::int32_t> found(moved.begin(), moved.end());
          for (std::int32_t i = BEGIN; i < PAIRS; ++i) {
            const CandidatePair& pair = pairs[static_cast<std::size_t>(i)];
            const double come = both ? std::max(nearer(pair, first), nearer(pair, second)) : nearer(pair, first);
            const double spare = pair.apart - (taken < 0.0 ? static_cast<double>(pair.reach) : taken);
            if (come >= spare) {
              EXPECT_TRUE(found.contains(i)) << isa_name(isa) << " " << i;
            } else if (come < spare * (1.0 - 1e-5) - 1e-5) {
              EXPECT_FALSE(found.contains(i)) << isa_name(isa) << " " << i;
            }
          }
          EXPECT_GT(found.size(), PAIRS / 10U);
          EXPECT_LT(found.size(), PAIRS * 9U / 10U);
        }
      }
    }
  }
}

} // namespace
} // namespace wry::contact
