#include "sim/scene/region.h"

#include <gtest/gtest.h>

#include "sim/geometry/structured_tets.h"

namespace wry::scene {
namespace {

// 5 x 5 x 5 lattice of [-1, 1]^3.
RestPoints lattice() {
  RestPoints points = rest_points(geometry::make_block_tets(geometry::box_block({2, 2, 2}),
                                                            geometry::BlockCells{{4, 4, 4}, geometry::CellSplit::five})
                                      .value());
  geometry::VertexAttribute mask{"mask", 1, std::vector<double>(125, 0.0)};
  mask.values[7] = 1;
  mask.values[99] = 0.6;
  mask.values[100] = 0.4;
  geometry::VertexAttribute colour{"colour", 3, std::vector<double>(375, 0.3)};
  colour.values[30] = -1;
  points.attributes = {mask, colour};
  return points;
}

std::vector<std::int32_t> chosen(const Region& region) {
  const Result<std::vector<std::int32_t>> indices = select_points(region, lattice(), Threads(2));
  EXPECT_TRUE(indices) << (indices ? "" : indices.error().message);
  return indices ? *indices : std::vector<std::int32_t>{};
}

std::string error_of(const Region& region) {
  const Result<std::vector<std::int32_t>> indices = select_points(region, lattice(), Threads(2));
  EXPECT_FALSE(indices);
  return indices ? "" : indices.error().message;
}

TEST(Region, BoxTakesItsBorders) {
  EXPECT_EQ(chosen(BoxRegion{{-1, -1, -1}, {1, -1, 1}}).size(), 25u);
  EXPECT_EQ(chosen(BoxRegion{{-9, -9, -9}, {9, -1 + 1e-16, 9}}).size(), 25u);
  EXPECT_EQ(chosen(BoxRegion{{-9, -9, -9}, {9, -1 - 1e-12, 9}}).size(), 25u);
  EXPECT_EQ(chosen(BoxRegion{{-0.6, -0.6, -0.6}, {0.6, 0.6, 0.6}}).size(), 27u);
}

TEST(Region, SphereAndCylinderTakeWhatIsWithinReach) {
  EXPECT_EQ(chosen(SphereRegion{{0, 0, 0}, 0.5}).size(), 7u);
  EXPECT_EQ(chosen(SphereRegion{{1, 1, 1}, 0.01}), std::vector<std::int32_t>{124});
  EXPECT_EQ(chosen(CylinderRegion{{0, -1, 0}, {0, 1, 0}, 0.5}).size(), 25u);
  EXPECT_EQ(chosen(CylinderRegion{{0, 0, 0}, {0, 1, 0}, 0.5}).size(), 15u);
  EXPECT_EQ(chosen(CylinderRegion{{0, 1, 0}, {0, 0, 0}, 0.5}).size(), 15u);
}

TEST(Region, FormulasAndAttributesChoose) {
  EXPECT_EQ(chosen(ExpressionRegion{"Y < -0.98"}).size(), 25u);
  EXPECT_EQ(chosen(ExpressionRegion{"u == 0 && v == 1"}).size(), 5u);
  EXPECT_EQ(chosen(ExpressionRegion{"mask > 0.3"}).size(), 3u);
  EXPECT_EQ(chosen(AttributeRegion{"mask"}), (std::vector<std::int32_t>{7, 99}));
  EXPECT_EQ(chosen(AttributeRegion{"mask", 0.3}), (std::vector<std::int32_t>{7, 99, 100}));
  EXPECT_EQ(chosen(AttributeRegion{"colour", 0.9}), std::vector<std::int32_t>{10});
}

TEST(Region, EmptyChoiceNamesTheExtentsOfTheBody) {
  const std::string message = error_of(ExpressionRegion{"Y < -2"});
  EXPECT_NE(message.find("Y -1..1"), std::string::npos) << message;
}

TEST(Region, NonsenseIsRefused) {
  EXPECT_NE(error_of(BoxRegion{{0, 1, 0}, {1, 0, 1}}).find("min <= max"), std::string::npos);
  EXPECT_NE(error_of(SphereRegion{{0, 0, 0}, -1}).find("-1"), std::string::npos);
  EXPECT_NE(error_of(CylinderRegion{{0, 0, 0}, {0, 0, 0}, 1}).find("length 0"), std::string::npos);
  EXPECT_NE(error_of(ExpressionRegion{"t < 1"}).find("depends on the time"), std::string::npos);
  EXPECT_NE(error_of(ExpressionRegion{"Q < 1"}).find("unknown name 'Q'"), std::string::npos);
  EXPECT_NE(error_of(AttributeRegion{"wet"}).find("it has mask, colour"), std::string::npos);
  EXPECT_FALSE(select_points(SphereRegion{{0, 0, 0}, 1}, RestPoints{}, Threads(1)));
}

} // namespace
} // namespace wry::scene
