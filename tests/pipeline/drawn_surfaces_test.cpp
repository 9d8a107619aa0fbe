#include "pipeline/plan/drawn_surfaces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/geometry/primitives.h"
#include "sim/geometry/structured_tets.h"
#include "tests/pipeline/import_files_support.h"
#include "tests/shots/shots_support.h"

namespace wry::pipeline {
namespace {

using ::testing::HasSubstr;

/// A ball as an artist's file, and elements that fill a cube about its middle.
struct Scene {
  explicit Scene(double side, const std::string& more = {}) {
    surface = *geometry::make_sphere(0.5, 0.2);
    const std::string path = folder.write("ball.ply", mesh_file_bytes(surface, "ply-little"));
    const Result<shots::Shot> loaded =
        shots::load_text("[shot]\nname = \"small\"\n[[body]]\nname = \"ball\"\nmesh = \"" + path +
                         "\"\nresolution = 0.1\nmaterial = \"skin\"\n" + more +
                         "\n[material.skin]\nmodel = \"neo-hookean\"\nyoungs_modulus = 5e4\npoisson_ratio = "
                         "0.3\n[look.own]\nown_materials = true\n");
    if (!loaded) {
      ADD_FAILURE() << loaded.error().message;
      return;
    }
    shot = *loaded;
    const geometry::TetMesh cube = *geometry::make_block_tets(geometry::box_block(Vec3::Constant(side)), side / 3);
    SceneBody body;
    body.name = "ball";
    body.rest_positions = cube.vertices;
    body.tets = cube.tets;
    body.triangles = geometry::boundary_triangles(cube);
    simulated.bodies = {body};
  }

  TemporaryFolder folder;
  geometry::SurfaceMesh surface;
  shots::Shot shot;
  SceneStatic simulated;
};

Channel channel(const std::string& name, const Points& rows) {
  Channel made;
  made.name = name;
  made.components = 3;
  made.values.assign(rows.data(), rows.data() + rows.size());
  return made;
}

Points rows_of(const Channel& channel) {
  return Eigen::Map<const Points>(channel.values.data(), static_cast<Eigen::Index>(channel.values.size() / 3), 3);
}

TEST(DrawnSurfaces, TheArtistsMeshRidesOnTheElements) {
  const Scene scene(1.2);
  const Result<DrawnSurfaces> drawn = DrawnSurfaces::create(scene.shot, scene.simulated);
  ASSERT_TRUE(drawn) << drawn.error().message;
  const SceneBody& body = drawn->scene().bodies[0];
  ASSERT_EQ(body.triangles.rows(), scene.surface.triangles.rows());
  EXPECT_EQ(body.tets.rows(), 0);
  EXPECT_LT((body.rest_positions - scene.surface.vertices).cwiseAbs().maxCoeff(), 1e-6); // the file has floats
  Mat3 shear = Mat3::Identity();
  shear(0, 1) = 0.7;
  const Points moved =
      (scene.simulated.bodies[0].rest_positions * shear.transpose()).rowwise() + Vec3(1, 2, 3).transpose();
  Frame frame;
  frame.bodies.resize(1);
  Channel of_tets;
  of_tets.name = "strain";
  of_tets.on = ChannelOn::tet;
  frame.bodies[0].channels = {channel("position", moved), channel("velocity", moved), of_tets};
  const Frame carried = drawn->carry(frame);
  const Points wanted = (body.rest_positions * shear.transpose()).rowwise() + Vec3(1, 2, 3).transpose();
  ASSERT_EQ(carried.bodies[0].channels.size(), 2U);
  for (const char* name : {"position", "velocity"}) {
    const Channel* there = find_channel(carried.bodies[0], name);
    ASSERT_NE(there, nullptr) << name;
    EXPECT_LT((rows_of(*there) - wanted).cwiseAbs().maxCoeff(), 1e-12) << name;
  }
}

TEST(DrawnSurfaces, ElementsAreDrawnWhereTheShotSaysSo) {
  const Scene scene(1.2, "draw = \"elements\"");
  const Result<DrawnSurfaces> drawn = DrawnSurfaces::create(scene.shot, scene.simulated);
  ASSERT_TRUE(drawn) << drawn.error().message;
  EXPECT_EQ(drawn->scene().bodies[0].triangles.rows(), scene.simulated.bodies[0].triangles.rows());
  Frame frame;
  frame.bodies.resize(1);
  frame.bodies[0].channels = {channel("position", scene.simulated.bodies[0].rest_positions)};
  EXPECT_EQ(find_channel(drawn->carry(frame).bodies[0], "position")->values, frame.bodies[0].channels[0].values);
}

TEST(DrawnSurfaces, AShapeThatItsElementsDoNotReachIsNotStretchedOntoThem) {
  const Scene scene(0.3);
  const Result<DrawnSurfaces> drawn = DrawnSurfaces::create(scene.shot, scene.simulated);
  ASSERT_TRUE(drawn) << drawn.error().message;
  EXPECT_EQ(drawn->scene().bodies[0].tets.rows(), scene.simulated.bodies[0].tets.rows());
  ASSERT_EQ(drawn->notes().size(), 1U);
  EXPECT_THAT(drawn->notes()[0], HasSubstr("ball"));
  const Scene insisting(0.3, "draw = \"shape\"");
  const Result<DrawnSurfaces> refused = DrawnSurfaces::create(insisting.shot, insisting.simulated);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_input);
  EXPECT_THAT(refused.error().message, HasSubstr("body.resolution finer"));
}

TEST(DrawnSurfaces, TheMaterialsOfTheFileAreWornByItsMeshOnly) {
  const Scene scene(1.2, "look = \"own\"");
  const Result<DrawnSurfaces> drawn = DrawnSurfaces::create(scene.shot, scene.simulated);
  ASSERT_TRUE(drawn) << drawn.error().message;
  ASSERT_EQ(drawn->appearances().count("ball"), 1U);
  EXPECT_EQ(static_cast<Eigen::Index>(drawn->appearances().at("ball")->material_of_triangle.size()),
            drawn->scene().bodies[0].triangles.rows());
  const Scene elements(1.2, "look = \"own\"\ndraw = \"elements\"");
  const Result<DrawnSurfaces> refused = DrawnSurfaces::create(elements.shot, elements.simulated);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("draw = \"shape\""));
}

} // namespace
} // namespace wry::pipeline
