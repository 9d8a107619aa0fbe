#include <array>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "sim/mpm/boundaries.h"
#include "tests/mpm/mpm_support.h"
#include "tests/mpm/vectors_support.h"
#include "tests/vector_files.h"

namespace wry::mpm {
namespace {

using namespace test;
using nlohmann::json;

scene::ColliderContact contact_of(const json& mode) {
  static const std::map<std::string, scene::ColliderContact> CONTACTS = {
      {"sticky", scene::ColliderContact::sticky},
      {"slip", scene::ColliderContact::slip},
      {"separate", scene::ColliderContact::separate}};
  return CONTACTS.at(mode);
}

TEST(MpmVectors, ContactLeavesTheVelocitiesOfTheReference) {
  std::set<std::string> modes;
  int checked = 0;
  for (const json& vector : wry::test::all_vectors()) {
    if (vector.value("kind", "") != "contact")
      continue;
    const json& input = vector.at("input");
    const std::string mode = input.at("mode");
    const Vec3 found = contact_velocity(vec3(input.at("v")), vec3(input.at("v_collider")), vec3(input.at("normal")),
                                        contact_of(mode), input.value("mu", 0.0));
    expect_close(found, vec3(vector.at("output").at("v")), vector.at("rel_tol"), vector.at("id"));
    modes.insert(mode);
    ++checked;
  }
  EXPECT_GE(checked, 4);
  EXPECT_GE(modes.size(), 2u);
}

TEST(MpmVectors, StickyContactTakesTheVelocityOfTheWall) {
  EXPECT_EQ(contact_velocity({1, 2, 3}, {-1, 0, 4}, Vec3::UnitZ(), scene::ColliderContact::sticky, 0.3),
            Vec3(-1, 0, 4));
}

/// A material that compile_material() makes the vector's matter of; the shot's keys have names, the vector's order is
/// that of `vectors_support`.
Material material_of(const json& input) {
  const Matter matter = matter_of(input);
  const OrthotropicElasticity e = elasticity_of(input.at("ortho"));
  Material material;
  material.name = "vector";
  material.density = input.at("rho");
  material.elasticity = matter.elasticity;
  material.measure = matter.measure;
  material.plasticity = matter.plasticity.law;
  material.frame = input.at("frame") == "polar" ? FrameMode::polar : FrameMode::shape;
  material.youngs_modulus = {e.youngs_modulus.x(), e.youngs_modulus.y(), e.youngs_modulus.z()};
  material.poisson_ratio.yz = e.nu_yz;
  material.poisson_ratio.xz = e.nu_xz;
  material.poisson_ratio.xy = e.nu_xy;
  const Vec3 a = vec3(input.at("a"));
  material.plastic_scale = {a.x(), a.y(), a.z()};
  material.fictitious = Material::Isotropic{input.at("Ebar"), input.at("nubar")};
  if (!input.at("phi_deg").is_null())
    material.friction_angle = input.at("phi_deg").get<double>() * 0.017453292519943295;
  return material;
}

MpmPlan plan_of(const json& input) {
  const Eigen::MatrixXd positions = matrix(input.at("x")), velocities = matrix(input.at("v"));
  MpmPlan plan;
  plan.gravity = vec3(input.at("gravity"));
  plan.settings.cell = input.at("h");
  plan.settings.precision = Precision::f64;
  plan.settings.transfer = input.at("grad_v") == "mls" ? Transfer::mls : Transfer::gradient;
  plan.settings.time_step = input.at("dt");
  MpmBody body;
  body.name = "vector";
  body.material = material_of(input);
  body.positions = std::make_shared<const Points>(positions);
  body.particle_volume = input.at("volume");
  body.frame = mat3(input.at("Q"));
  // Nothing beside the particles: the solver starts C as the field's slope, and C is 0 in the vectors.
  body.velocity_field = [positions, velocities](const Vec3& at) -> Vec3 {
    for (Eigen::Index p = 0; p < positions.rows(); ++p) {
      if (positions.row(p).transpose() == at)
        return velocities.row(p);
    }
    return Vec3::Zero();
  };
  plan.bodies.push_back(std::move(body));
  const json& wall = input.at("collider");
  auto plane = std::make_shared<scene::Collider>();
  plane->name = "plane";
  plane->shape = scene::PlaneObstacle{vec3(wall.at("point")), vec3(wall.at("normal"))};
  plane->contact = contact_of(wall.at("mode"));
  plane->friction = wall.at("mu");
  plan.colliders.push_back(plane);
  return plan;
}

/// A channel of the state with every bit, a row per particle in the order of identities.
Eigen::MatrixXd state_of(const MpmSimulation& simulation, const std::string& name) {
  const auto find = [archive = simulation.archive()](const std::string& key) {
    for (const NamedArray& array : archive) {
      if (array.name == "mpm/0/" + key)
        return array;
    }
    ADD_FAILURE() << "no array " << key;
    return NamedArray{};
  };
  const NamedArray identity = find("identity"), channel = find(name);
  const std::size_t tiles = channel.shape.at(0), components = channel.shape.at(1), width = channel.shape.at(2);
  Eigen::MatrixXd rows(simulation.particle_count(), components);
  std::set<Eigen::Index> seen; // lanes past the end of a run repeat its last particle
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    for (std::size_t lane = 0; lane < width; ++lane) {
      const auto row = static_cast<Eigen::Index>(identity.values.at(tile * width + lane));
      if (!seen.insert(row).second)
        continue;
      for (std::size_t c = 0; c < components; ++c)
        rows(row, static_cast<Eigen::Index>(c)) = channel.values.at((tile * components + c) * width + lane);
    }
  }
  return rows;
}

/// A list of 3x3 matrices, a row of nine each.
Eigen::MatrixXd matrices(const json& list) {
  Eigen::MatrixXd rows(list.size(), 9);
  for (std::size_t p = 0; p < list.size(); ++p)
    rows.row(static_cast<Eigen::Index>(p)) = mat3(list.at(p)).transpose().reshaped().transpose();
  return rows;
}

void check_ten_steps(const json& vector) {
  const json& input = vector.at("input");
  const json& output = vector.at("output");
  const std::unique_ptr<MpmSimulation> simulation = make(plan_of(input));
  const int steps = input.at("steps");
  const double dt = input.at("dt");
  for (int i = 1; i <= steps; ++i) {
    const Result<StepStats> step = simulation->step(i * dt);
    ASSERT_TRUE(step) << step.error().message;
    ASSERT_NEAR(step->dt, dt, 1e-15) << "a step of the vector was cut";
  }
  const double tolerance = vector.at("rel_tol");
  const std::string id = vector.at("id");
  expect_close(channel_of(*simulation, 0, "position"), matrix(output.at("x")), tolerance, id + " x");
  expect_close(state_of(*simulation, "velocity"), matrix(output.at("v")), tolerance, id + " v");
  expect_close(state_of(*simulation, "affine"), matrices(output.at("C")), tolerance, id + " C");
  expect_close(state_of(*simulation, "deformation"), matrices(output.at("F")), tolerance, id + " F");
  const Frame frame = simulation->snapshot(0);
  const wry::Channel* turned = find_channel(frame.bodies.at(0), "orientation");
  ASSERT_NE(turned, nullptr);
  const Eigen::MatrixXd stress = state_of(*simulation, "stress");
  Eigen::MatrixXd frames(stress.rows(), 9), tau(stress.rows(), 9);
  constexpr std::array<Eigen::Index, 9> PLACE = {0, 5, 4, 5, 1, 3, 4, 3, 2}; // in xx yy zz yz zx xy
  for (Eigen::Index p = 0; p < stress.rows(); ++p) {
    const double* q = turned->values.data() + 4 * p;
    frames.row(p) = rotation_matrix(Vec4(q[0], q[1], q[2], q[3])).transpose().reshaped().transpose();
    for (std::size_t i = 0; i < 9; ++i)
      tau(p, static_cast<Eigen::Index>(i)) = stress(p, PLACE[i]);
  }
  expect_close(frames, matrices(output.at("Q")), tolerance, id + " Q");
  expect_close(tau, matrices(output.at("tau")), tolerance, id + " tau");
}

TEST(MpmVectors, TenStepsOfTheSolverEndWhereTheReferenceDoes) {
  int checked = 0;
  for (const json& vector : wry::test::all_vectors()) {
    if (vector.value("kind", "") != "mpm10")
      continue;
    check_ten_steps(vector);
    ++checked;
  }
  EXPECT_GE(checked, 2);
}

TEST(MpmVectors, EveryKindOfVectorHasAReader) {
  // Read by matter_vectors_test.cpp, by this file, and by the tests of FEM and of rotations.
  const std::set<std::string> read = {"maps", "isotropic_fit", "ortho_check", "stress",  "project",
                                      "pi2",  "shape_match",   "interpolate", "contact", "mpm10",
                                      "tet",  "plate",         "scalars"};
  std::set<std::string> known;
  for (const json& vector : wry::test::all_vectors()) {
    const std::string kind = vector.value("kind", "");
    EXPECT_TRUE(read.contains(kind)) << vector.value("id", "?") << ": nothing reads vectors of kind " << kind;
    known.insert(kind);
  }
  EXPECT_EQ(known, read) << "a reader has no vector";
}

} // namespace
} // namespace wry::mpm
