#include "sim/contact/box_tree.h"

#include <random>

#include <gtest/gtest.h>

#include "sim/contact/distance.h"

namespace wry::contact {
namespace {

/// Boxes of some size about places in the unit cube.
std::vector<Box> boxes_about(const std::vector<std::array<double, 3>>& places, double size) {
  std::vector<Box> boxes;
  for (const std::array<double, 3>& place : places) {
    Box box;
    for (int i = 0; i < 3; ++i) {
      box.low[i] = place[static_cast<std::size_t>(i)];
      box.high[i] = box.low[i] + size;
    }
    boxes.push_back(box);
  }
  return boxes;
}

std::vector<std::int32_t> found(const BoxTree& tree, const Box& query, std::int32_t after = -1) {
  std::vector<std::int32_t> indices;
  tree.query(
      query, [&](std::int32_t index) { indices.push_back(index); }, after);
  std::sort(indices.begin(), indices.end());
  return indices;
}

std::vector<std::int32_t> looked_through(const std::vector<Box>& boxes, std::size_t begin, std::size_t end,
                                         const Box& query) {
  std::vector<std::int32_t> indices;
  for (std::size_t i = begin; i < end; ++i) {
    if (boxes[i].meets(query))
      indices.push_back(static_cast<std::int32_t>(i));
  }
  return indices;
}

TEST(BoxTree, FindsTheSameAfterItsBoxesMovedALittleOrAnywhere) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(0.0, 1.0);
  std::vector<std::array<double, 3>> places(400);
  constexpr std::size_t BEGIN = 37, END = 391;
  BoxTree tree;
  for (int round = 0; round < 12; ++round) {
    // A little in most rounds, anywhere in every fourth.
    for (std::array<double, 3>& where : places) {
      for (double& x : where)
        x = round % 4 == 0 ? place(random) : x + 0.02 * (place(random) - 0.5);
    }
    const std::vector<Box> boxes = boxes_about(places, 0.05);
    tree.update(boxes, BEGIN, END);
    std::size_t hits = 0;
    for (const Box& query : boxes) {
      const std::vector<std::int32_t> expected = looked_through(boxes, BEGIN, END, query);
      hits += expected.size();
      ASSERT_EQ(found(tree, query), expected) << round;
      ASSERT_EQ(found(tree, query, 199), looked_through(boxes, 200, END, query)) << round;
    }
    EXPECT_GT(hits, 400u);
  }
  tree.update({}, 0, 0);
  EXPECT_TRUE(found(tree, boxes_about({{0.0, 0.0, 0.0}}, 9.0).front()).empty());
}

MovingBox moving(std::mt19937& random, double size, double speed) {
  std::uniform_real_distribution<float> place(0.0F, 1.0F);
  const auto triple = [&](double scale) -> Eigen::Array4f {
    return Eigen::Array4f(place(random), place(random), place(random), 0.0F) * static_cast<float>(scale);
  };
  MovingBox box;
  box.low = triple(1.0);
  box.high = box.low + triple(size);
  box.way_low = triple(speed) - 0.5F * static_cast<float>(speed) * Eigen::Array4f(1.0F, 1.0F, 1.0F, 0.0F);
  box.way_high = box.way_low + triple(0.1 * speed);
  return box;
}

bool overlap_at(const MovingBox& a, const MovingBox& b, float time) {
  const Eigen::Array4f gap = ((a.low + time * a.way_low) - (b.high + time * b.way_high))
                                 .max((b.low + time * b.way_low) - (a.high + time * a.way_high));
  return gap.maxCoeff() <= 0.0F;
}

TEST(MovingTree, MissesNoBoxThatIsMetAtAnyTimeAndSparesWhatMovesAlong) {
  std::mt19937 random(7);
  std::vector<MovingBox> boxes;
  boxes.reserve(600);
  for (int i = 0; i < 600; ++i)
    boxes.push_back(moving(random, 0.05, 0.4));
  MovingTree tree;
  tree.build(boxes);
  std::size_t met = 0;
  std::size_t found = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    std::vector<char> seen(boxes.size(), 0);
    tree.query(boxes[i], [&](std::int32_t j) { seen[static_cast<std::size_t>(j)] = 1; });
    for (std::size_t j = 0; j < boxes.size(); ++j) {
      bool meets = false;
      for (int k = 0; k <= 16; ++k)
        meets = meets || overlap_at(boxes[i], boxes[j], static_cast<float>(k) / 16.0F);
      EXPECT_TRUE(!meets || seen[j] != 0) << i << " " << j;
      met += meets ? 1 : 0;
      found += seen[j] != 0 ? 1 : 0;
    }
  }
  EXPECT_GT(met, 2 * boxes.size());
  EXPECT_LT(found, boxes.size() * boxes.size() / 4);
  MovingBox along = boxes[0];
  along.low += 0.2F; // beside it, and as fast
  along.high += 0.2F;
  along.way_low = along.way_high = boxes[0].way_high = boxes[0].way_low;
  EXPECT_FALSE(boxes[0].meets(along));
}

TEST(BoxPack, MeetsWhatEachOfItsBoxesMeets) {
  std::mt19937 random(13);
  int met = 0;
  for (int round = 0; round < 400; ++round) {
    BoxPack<MovingBox> pack;
    MovingBox whole;
    std::array<MovingBox, 4> boxes;
    const int count = 1 + round % 4;
    for (int lane = 0; lane < count; ++lane) {
      boxes[static_cast<std::size_t>(lane)] = moving(random, 0.3, 0.4);
      pack.put(lane, boxes[static_cast<std::size_t>(lane)]);
      if (lane == 0)
        whole = boxes[0];
      whole.include(boxes[static_cast<std::size_t>(lane)]);
    }
    const MovingBox query = moving(random, 0.3, 0.4);
    for (int lane = 0; lane < 4; ++lane) {
      const bool meets = lane < count && boxes[static_cast<std::size_t>(lane)].meets(query);
      EXPECT_EQ((pack.meeting(query) >> lane) & 1U, meets ? 1U : 0U) << lane << " of " << count;
      met += meets ? 1 : 0;
    }
    EXPECT_TRUE((pack.whole().low == whole.low).all() && (pack.whole().high == whole.high).all());
    EXPECT_TRUE((pack.whole().way_low == whole.way_low).all() && (pack.whole().way_high == whole.way_high).all());
  }
  EXPECT_GT(met, 30);
}

/// Pairs of points that are near each other, and go ways as long.
template <class Scalar> void expect_no_quick_gap_is_too_large() {
  std::mt19937 random(17);
  std::uniform_real_distribution<Scalar> number(Scalar(-1), Scalar(1));
  const auto triple = [&] { return Four<Scalar>(number(random), number(random), number(random), Scalar(0)); };
  int told = 0;
  for (int round = 0; round < 3000; ++round) {
    std::vector<MovingPoint<Scalar>> nodes;
    nodes.reserve(4);
    for (int k = 0; k < 4; ++k)
      nodes.push_back({triple(), triple()});
    const double rounding = rounding_of_boxes<Scalar>(1.0);
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
      const QuickPair<Scalar> quick(kind, {0, 1, 2, 3}, nodes);
      const auto distance_at = [&](double time) {
        PairPoints points;
        for (int k = 0; k < 4; ++k) {
          const MovingPoint<Scalar>& node = nodes[static_cast<std::size_t>(k)];
          points.row(k) =
              (node.place.template cast<double>() + time * node.way.template cast<double>()).template head<3>();
        }
        return std::sqrt(squared_distance(kind, points));
      };
      const QuickGap gap = quick.between_middles(rounding);
      EXPECT_LE(gap.start, distance_at(0.0));
      EXPECT_LE(quick.between_nearest(rounding), distance_at(0.0));
      for (int step = 0; step <= 8; ++step)
        EXPECT_LE(gap.least, distance_at(step / 8.0));
      told += gap.least > 0.0 ? 1 : 0;
      for (const double distance : {0.0, 0.1, 0.5, std::max(gap.least, 0.0)}) {
        if (quick.is_beyond(distance, rounding)) {
          EXPECT_GT(gap.least, distance);
        } else {
          EXPECT_LT(gap.least, (distance + rounding) * 1.0001);
        }
      }
    }
  }
  EXPECT_GT(told, 300);
}

TEST(QuickPair, IsNeverFartherApartThanThePairIs) {
  expect_no_quick_gap_is_too_large<float>();
  expect_no_quick_gap_is_too_large<double>();
}

TEST(MovingTree, AGroupOfBoxesFindsWhatEachOfThemFinds) {
  std::mt19937 random(11);
  std::vector<MovingBox> boxes;
  boxes.reserve(300);
  for (int i = 0; i < 300; ++i)
    boxes.push_back(moving(random, 0.1, 0.2));
  MovingTree tree;
  tree.build(boxes);
  const MovingBox group[3] = {boxes[4], boxes[5], boxes[6]};
  MovingBox around = group[0];
  around.include(group[1]);
  around.include(group[2]);
  const std::int32_t after[3] = {4, 5, -1};
  std::vector<std::vector<std::int32_t>> together(3), alone(3);
  tree.query(group, 3, around, after,
             [&](int which, std::int32_t j) { together[static_cast<std::size_t>(which)].push_back(j); });
  for (std::size_t which = 0; which < 3; ++which) {
    tree.query(
        group[which], [&](std::int32_t j) { alone[which].push_back(j); }, after[which]);
    std::sort(together[which].begin(), together[which].end());
    std::sort(alone[which].begin(), alone[which].end());
    EXPECT_FALSE(alone[which].empty());
    EXPECT_EQ(together[which], alone[which]);
  }
}

} // namespace
} // namespace wry::contact
