#include "sim/contact/box_tree.h"

#include <random>

#include <gtest/gtest.h>

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

} // namespace
} // namespace wry::contact
