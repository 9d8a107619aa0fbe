#include <cmath>

#include <gtest/gtest.h>

#include "render/burial.h"
#include "render/drawable_scene.h"
#include "render/grain_shapes.h"
#include "render/subject_bounds.h"
#include "tests/render/shapes_support.h"

namespace wry::render {
namespace {

using Vector = Eigen::Vector3f;

Vector vector_of(const std::array<float, 3>& v) {
  return {v[0], v[1], v[2]};
}

DrawGrain turned_box() {
  const Eigen::Matrix3f axes = (Eigen::AngleAxisf(0.7f, Vector(1, 2, 0.5f).normalized()).toRotationMatrix() *
                                Eigen::Vector3f(0.1f, 0.2f, 0.5f).asDiagonal());
  DrawGrain grain{{0.3f, -0.2f, 0.1f}, {}, {0, 0, 0}, surface_word(3, 0)};
  for (int a = 0; a < 3; ++a)
    grain.axes[static_cast<std::size_t>(a)] = {axes(0, a), axes(1, a), axes(2, a)};
  return grain;
}

/// Area of triangles as seen along a direction; each turned towards it counts plus, each turned away minus.
double seen_area(const std::vector<Vector>& x, std::span<const std::uint32_t> indices, const Vector& towards) {
  double area = 0.0;
  for (std::size_t i = 0; i < indices.size(); i += 3)
    area += 0.5 * std::abs(static_cast<double>(
                      (x[indices[i + 1]] - x[indices[i]]).cross(x[indices[i + 2]] - x[indices[i]]).dot(towards)));
  return area;
}

/// What a box covers: the sum over its three pairs of faces.
double covered(const DrawGrain& grain, const Vector& towards) {
  const Vector x = vector_of(grain.axes[0]);
  const Vector y = vector_of(grain.axes[1]);
  const Vector z = vector_of(grain.axes[2]);
  return 4.0 * static_cast<double>(std::abs(x.cross(y).dot(towards)) + std::abs(y.cross(z).dot(towards)) +
                                   std::abs(z.cross(x).dot(towards)));
}

TEST(GrainShapes, BoxAndItsOutlineCoverWhatTheWholeBoxCovers) {
  const DrawGrain grain = turned_box();
  for (const Vector& direction : {Vector(1, 0.2f, 0.3f), Vector(-0.4f, 1, 0.1f), Vector(0.3f, -0.5f, -1)}) {
    const Vector towards = direction.normalized();
    const ViewPoint from{ViewPoint::Kind::direction, towards};
    std::vector<GrainVertex> box;
    append_boxes({&grain, 1}, from, 0.f, box);
    ASSERT_EQ(box.size(), static_cast<std::size_t>(BOX_VERTICES));
    std::vector<Vector> corners;
    for (const GrainVertex& vertex : box)
      corners.push_back(vector_of(vertex.position));
    EXPECT_NEAR(seen_area(corners, box_indices(), towards), covered(grain, towards), 1e-5);
    std::vector<std::array<float, 3>> outline;
    append_outlines({&grain, 1}, from, 0.f, outline);
    std::vector<Vector> ring;
    for (const std::array<float, 3>& corner : outline)
      ring.push_back(vector_of(corner));
    EXPECT_NEAR(seen_area(ring, outline_indices(), towards), covered(grain, towards), 1e-5);
    for (const Vector& corner : ring)
      EXPECT_NEAR((corner - vector_of(grain.centre)).dot(towards), 0.f, 1e-6f);
  }
}

TEST(GrainShapes, EachFaceHasOneNormalThatIsSquareToItAndFacesTheViewer) {
  const DrawGrain grain = turned_box();
  const Vector towards = Vector(0.5f, 0.4f, 0.8f).normalized();
  std::vector<GrainVertex> box;
  append_boxes({&grain, 1}, {ViewPoint::Kind::direction, towards}, 0.f, box);
  const auto indices = box_indices();
  for (std::size_t t = 0; t < indices.size(); t += 3) {
    const Vector a = vector_of(box[indices[t]].position);
    const Vector square =
        (vector_of(box[indices[t + 1]].position) - a).cross(vector_of(box[indices[t + 2]].position) - a).normalized();
    const std::uint32_t word = box[indices[t + 2]].normal;
    EXPECT_TRUE(
        word == octahedral_word(square) || word == octahedral_word(Vector(-square)) ||
        std::min(std::abs(static_cast<int>(word & 0xffffu) - static_cast<int>(octahedral_word(square) & 0xffffu)),
                 std::abs(static_cast<int>(word & 0xffffu) -
                          static_cast<int>(octahedral_word(Vector(-square)) & 0xffffu))) <= 2);
  }
}

TEST(GrainShapes, RoundShapesHaveTheRadiusAndLengthOfTheirGrain) {
  DrawGrain grain{{0, 0, 0}, {{{0.1f, 0, 0}, {0, 0.1f, 0}, {0, 0, 0.4f}}}, {0, 0, 0}, surface_word(0, 0)};
  GrainTriangles rod;
  append_cylinders({&grain, 1}, GrainShape::rod, 8, {ViewPoint::Kind::place, Vector(3, 1, 2)}, 0.f, rod);
  float longest = 0.f;
  for (const GrainVertex& vertex : rod.vertices) {
    EXPECT_NEAR(std::hypot(vertex.position[0], vertex.position[1]), 0.1f, 1e-5f);
    longest = std::max(longest, std::abs(vertex.position[2]));
  }
  EXPECT_NEAR(longest, 0.4f, 1e-6f);
  for (const std::uint32_t index : rod.indices)
    EXPECT_LT(index, rod.vertices.size());
  grain.axes = {{{0.2f, 0, 0}, {0, 0.2f, 0}, {0, 0, 0.2f}}};
  GrainTriangles ball;
  const Vector towards = Vector(1, 2, 3).normalized();
  append_spheres({&grain, 1}, 10, {ViewPoint::Kind::direction, towards}, 0.f, ball);
  std::vector<Vector> corners;
  for (const GrainVertex& vertex : ball.vertices)
    corners.push_back(vector_of(vertex.position));
  EXPECT_NEAR(seen_area(corners, ball.indices, towards), 3.14159265 * 0.04, 1e-3);
}

GrainCloud cloud_of(const MeshScene& scene) {
  View view;
  const Result<GrainCloud> cloud =
      make_grain_cloud(scene.scene.bodies[0], scene.frame.bodies[0], 1, Vec3::Zero(), view, Look(), 0);
  EXPECT_TRUE(cloud.ok());
  return *cloud;
}

TEST(Burial, LeavesOutTheInsideOfAHeapAndNothingOfALooseCloud) {
  // The deeper the heap, the larger the part that is buried.
  MeshScene large = testing::heap(400'000, {GrainShape::brick, Vec3(1, 1, 2)}, "straw");
  EXPECT_LT(exposed_grains(cloud_of(large)).visible.size(), 300'000U);
  MeshScene scene = testing::heap(60'000, {GrainShape::brick, Vec3(1, 1, 2)}, "straw");
  const Exposure exposure = exposed_grains(cloud_of(scene));
  EXPECT_LT(exposure.visible.size(), 60'000U);
  EXPECT_GT(exposure.visible.size(), 30'000U);
  EXPECT_LE(exposure.casting.size(), exposure.visible.size());
  EXPECT_TRUE(exposure.has_buried());
  const Exposure on_floor = exposed_grains(cloud_of(scene), Floor{});
  EXPECT_LT(on_floor.visible.size(), exposure.visible.size()); // nobody looks at it from below
  for (double& x : scene.frame.bodies[0].channels[0].values)
    x *= 4.0; // the same grains, 64 times looser
  EXPECT_EQ(exposed_grains(cloud_of(scene)).visible.size(), 60'000U);
}

TEST(Grains, ParticlesThatOnlyCarryThemDoNotCountAsSomethingDrawn) {
  MeshScene scene = testing::heap(500, {GrainShape::rod, Vec3(1, 1, 6)}, "straw");
  SubjectBounds alone;
  ASSERT_TRUE(alone.include(scene.scene, scene.frame).ok());
  // A body without triangles whose frame has places far away.
  SceneBody carriers;
  carriers.name = "carriers";
  scene.scene.bodies.push_back(carriers);
  FrameBody on_frame;
  on_frame.name = "carriers";
  on_frame.channels.push_back({"position", ChannelOn::particle, 3, ChannelStorage::float64, {50, 60, 70, 80, 90, 99}});
  scene.frame.bodies.push_back(on_frame);
  SubjectBounds both;
  const Status status = both.include(scene.scene, scene.frame);
  ASSERT_TRUE(status.ok()) << status.error().message;
  EXPECT_EQ(alone.centre(), both.centre());
}

TEST(Grains, VaryFromGrainToGrainButNotFromFrameToFrame) {
  MeshScene scene = testing::heap(500, {GrainShape::rod, Vec3(1, 1, 6)}, "straw");
  Look look;
  look.colour_variation = 0.3f;
  look.size_variation = 0.2f;
  View view;
  const auto cloud = [&] {
    return *make_grain_cloud(scene.scene.bodies[0], scene.frame.bodies[0], 1, Vec3::Zero(), view, look, 2);
  };
  const GrainCloud first = cloud();
  for (double& x : scene.frame.bodies[0].channels[0].values)
    x += 0.25;
  const GrainCloud second = cloud();
  int different = 0;
  for (std::size_t i = 0; i < first.grains.size(); ++i) {
    EXPECT_EQ(first.grains[i].word, second.grains[i].word);
    EXPECT_EQ(first.grains[i].axes, second.grains[i].axes);
    different += i > 0 && first.grains[i].word != first.grains[i - 1].word ? 1 : 0;
  }
  EXPECT_GT(different, 400);
}

} // namespace
} // namespace wry::render
