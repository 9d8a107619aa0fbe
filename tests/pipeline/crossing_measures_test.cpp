#include "pipeline/measure/crossing_measures.h"

#include <cmath>

#include <gtest/gtest.h>

namespace wry::pipeline {
namespace {

/// A tet with its corner at a place and edges of 1 m along the axes.
SceneBody tet_at(const std::string& name, const Vec3& corner) {
  SceneBody body;
  body.name = name;
  body.rest_positions.resize(4, 3);
  body.rest_positions << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  body.rest_positions.rowwise() += corner.transpose();
  body.tets.resize(1, 4);
  body.tets << 0, 1, 2, 3;
  body.triangles.resize(4, 3);
  body.triangles << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  return body;
}

/// Both as one body.
SceneBody joined(const SceneBody& a, const SceneBody& b) {
  SceneBody body;
  body.name = a.name;
  body.rest_positions.resize(8, 3);
  body.rest_positions << a.rest_positions, b.rest_positions;
  body.tets.resize(2, 4);
  body.tets << 0, 1, 2, 3, 4, 5, 6, 7;
  body.triangles.resize(8, 3);
  body.triangles << a.triangles, (b.triangles.array() + 4).matrix();
  return body;
}

Frame frame_of(const SceneStatic& scene) {
  Frame frame;
  for (const SceneBody& body : scene.bodies) {
    FrameBody state;
    state.name = body.name;
    Channel position;
    position.name = "position";
    position.components = 3;
    position.values.assign(body.rest_positions.data(), body.rest_positions.data() + body.rest_positions.size());
    state.channels.push_back(position);
    frame.bodies.push_back(state);
  }
  return frame;
}

double count(const SceneStatic& scene, std::size_t body, std::vector<std::int32_t> nodes = {}) {
  MeasurePlan plan;
  plan.kind = shots::MeasureKind::crossings;
  plan.body = body;
  plan.nodes = std::move(nodes);
  return evaluate_measure(plan, scene, frame_of(scene));
}

/// Here the second's corner is in the first, which its three edges from there leave through the slanted face; no edge
/// of the first reaches into the second.
const Vec3 INSIDE(0.2, 0.2, 0.2);

TEST(CrossingMeasure, CountsWhatCutsBodiesAndThemselves) {
  const SceneBody first = tet_at("first", Vec3::Zero());
  const SceneBody inside = tet_at("second", INSIDE);
  const SceneBody apart = tet_at("third", Vec3(5, 0, 0));
  EXPECT_EQ(count({{first, apart}}, 0), 0.0);
  EXPECT_EQ(count({{first, inside, apart}}, 0), 3.0) << "three edges leave the first through its slanted face";
  EXPECT_EQ(count({{first, inside, apart}}, 1), 3.0);
  EXPECT_EQ(count({{first, inside, apart}}, 2), 0.0);
  EXPECT_EQ(count({{apart, joined(first, inside)}}, 1), 3.0) << "of a body with itself";
  EXPECT_EQ(count({{apart, joined(first, inside)}}, 0), 0.0);
}

TEST(CrossingMeasure, TouchingCounts) {
  EXPECT_EQ(count({{tet_at("first", Vec3::Zero()), tet_at("second", Vec3(1.0, 0.0, 0.0))}}, 0) > 0.0, true);
  EXPECT_EQ(count({{tet_at("first", Vec3::Zero()), tet_at("second", Vec3(1.0 + 1e-15, 0.0, 0.0))}}, 0), 0.0);
}

TEST(CrossingMeasure, LooksAtPickedNodesOnly) {
  const SceneStatic scene{{tet_at("first", Vec3::Zero()), tet_at("second", INSIDE)}};
  EXPECT_EQ(count(scene, 1, {0}), 3.0) << "all three edges end in the corner that is inside";
  EXPECT_EQ(count(scene, 1, {2}), 1.0);
  EXPECT_EQ(count(scene, 0, {0}), 0.0) << "the slanted face has the other three";
}

TEST(CrossingMeasure, CollidersDoNotCountAndLostPositionsAreNoNumber) {
  SceneBody collider = tet_at("collider", INSIDE);
  collider.tets.resize(0, 4);
  collider.simulated = false;
  const SceneStatic scene{{tet_at("first", Vec3::Zero()), collider}};
  EXPECT_EQ(count(scene, 0), 0.0);
  Frame frame = frame_of(scene);
  frame.bodies[0].channels.clear();
  MeasurePlan plan;
  plan.kind = shots::MeasureKind::crossings;
  EXPECT_TRUE(std::isnan(evaluate_measure(plan, scene, frame)));
}

} // namespace
} // namespace wry::pipeline
