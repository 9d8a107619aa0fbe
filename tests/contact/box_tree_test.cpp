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

std::vector<std::int32_t> found(const BoxTree& tree, const Box& query) {
  std::vector<std::int32_t> indices;
  tree.query(query, [&](std::int32_t index) { indices.push_back(index); });
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
    }
    EXPECT_GT(hits, 400u);
  }
  tree.update({}, 0, 0);
  EXPECT_TRUE(found(tree, boxes_about({{0.0, 0.0, 0.0}}, 9.0).front()).empty());
}

template <class T> MovingBoxOf<T> moving(std::mt19937& random, double size, double speed) {
  std::uniform_real_distribution<T> place(T(0), T(1));
  const auto triple = [&](double scale) -> Four<T> {
    return Four<T>(place(random), place(random), place(random), T(0)) * static_cast<T>(scale);
  };
  MovingBoxOf<T> box;
  box.low = triple(1.0);
  box.high = box.low + triple(size);
  box.way_low = triple(speed) - Four<T>(T(0.5), T(0.5), T(0.5), T(0)) * static_cast<T>(speed);
  box.way_high = box.way_low + triple(0.1 * speed);
  return box;
}

bool overlap_at(const MovingBox& a, const MovingBox& b, float time) {
  const Eigen::Array4f gap = ((a.low + time * a.way_low) - (b.high + time * b.way_high))
                                 .max((b.low + time * b.way_low) - (a.high + time * a.way_high));
  return gap.maxCoeff() <= 0.0F;
}

TEST(MovingBox, MissesNoBoxThatIsMetAtAnyTimeAndSparesWhatMovesAlong) {
  std::mt19937 random(7);
  std::vector<MovingBox> boxes;
  boxes.reserve(600);
  for (int i = 0; i < 600; ++i)
    boxes.push_back(moving<float>(random, 0.05, 0.4));
  std::size_t met = 0;
  std::size_t found = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = 0; j < boxes.size(); ++j) {
      bool meets = false;
      for (int k = 0; k <= 16; ++k)
        meets = meets || overlap_at(boxes[i], boxes[j], static_cast<float>(k) / 16.0F);
      EXPECT_TRUE(!meets || boxes[i].meets(boxes[j])) << i << " " << j;
      met += meets ? 1 : 0;
      found += boxes[i].meets(boxes[j]) ? 1 : 0;
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

TEST(MovingBoxes, AreWholeAroundAllThatWerePut) {
  std::mt19937 random(13);
  for (int count = 1; count <= 4; ++count) {
    MovingBoxes<float> pack;
    clear(pack);
    MovingBox around = moving<float>(random, 0.3, 0.4);
    put(pack, 0, around);
    double sides = static_cast<double>((around.high - around.low).sum());
    for (int lane = 1; lane < count; ++lane) {
      const MovingBox box = moving<float>(random, 0.3, 0.4);
      put(pack, lane, box);
      around.include(box);
      sides += static_cast<double>((box.high - box.low).sum());
    }
    EXPECT_TRUE((whole(pack).low == around.low).all() && (whole(pack).high == around.high).all());
    EXPECT_TRUE((whole(pack).way_low == around.way_low).all() && (whole(pack).way_high == around.way_high).all());
    EXPECT_NEAR(sizes(pack), sides, 1e-6);
  }
}

} // namespace
} // namespace wry::contact
