#include "sim/base/rotation.h"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "tests/vector_files.h"

namespace wry {
namespace {

using nlohmann::json;

constexpr double PI = std::numbers::pi;

Vec4 random_quaternion(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec4(normal(random), normal(random), normal(random), normal(random)).normalized();
}

Vec3 random_vector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {normal(random), normal(random), normal(random)};
}

Vec4 quaternion(const json& entries) {
  return {entries.at(0).get<double>(), entries.at(1).get<double>(), entries.at(2).get<double>(),
          entries.at(3).get<double>()};
}

TEST(Rotation, ProductOfQuaternionsIsTheProductOfTheirMatrices) {
  std::mt19937 random(1);
  for (int i = 0; i < 20; ++i) {
    const Vec4 a = random_quaternion(random), b = random_quaternion(random);
    const Mat3 R = rotation_matrix(quaternion_product(a, b));
    EXPECT_LE((R - rotation_matrix(a) * rotation_matrix(b)).norm(), 1e-14);
    EXPECT_LE((R * R.transpose() - Mat3::Identity()).norm(), 1e-14);
    EXPECT_NEAR(R.determinant(), 1.0, 1e-14);
    EXPECT_LE((rotation_matrix(quaternion_conjugate(a)) - rotation_matrix(a).transpose()).norm(), 1e-15);
  }
}

TEST(Rotation, MatrixAndQuaternionAreInverse) {
  std::mt19937 random(2);
  for (int i = 0; i < 20; ++i) {
    const Mat3 R = rotation_matrix(random_quaternion(random));
    EXPECT_LE((rotation_matrix(quaternion_of(R)) - R).norm(), 1e-14);
  }
  const Mat3 half_turn = Vec3(-1.0, 1.0, -1.0).asDiagonal();
  EXPECT_LE((rotation_matrix(quaternion_of(half_turn)) - half_turn).norm(), 1e-15);
}

TEST(Rotation, CayleyUpdateTurnsByTwiceTheArcTangentOfHalfTheIncrement) {
  std::mt19937 random(3);
  for (const double size : {1e-9, 0.01, 1.7, 20.0}) {
    const Vec4 q0 = random_quaternion(random);
    const Vec3 a = size * random_vector(random).normalized();
    const Vec4 q = cayley_update(q0, a);
    EXPECT_NEAR(q.norm(), 1.0, 1e-15);
    EXPECT_GT(q.dot(q0), 0.0);
    const double angle = 2.0 * std::atan(0.5 * size);
    EXPECT_NEAR(rotation_distance(q0, q), angle, 1e-15 * (1.0 + angle));
    EXPECT_LE((rotation_matrix(q) - rodrigues(angle / size * a) * rotation_matrix(q0)).norm(), 2e-15);
    EXPECT_LE((cayley_increment(q0, q) - a).norm(), 4e-16 * (1.0 + 20.0 * size * size));
    EXPECT_LE((cayley_increment(q0, -q) - a).norm(), 4e-16 * (1.0 + 20.0 * size * size));
  }
}

TEST(Rotation, CayleyMapOfTheMatrixIsThatOfTheQuaternion) {
  std::mt19937 random(4);
  const Vec3 a = random_vector(random);
  const Mat3 half = cross_matrix(0.5 * a);
  const Mat3 cayley = (Mat3::Identity() - half).inverse() * (Mat3::Identity() + half);
  EXPECT_LE((rotation_matrix(cayley_update(identity_quaternion(), a)) - cayley).norm(), 2e-15);
}

TEST(Rotation, ManyUpdatesKeepUnitLength) {
  Vec4 q = identity_quaternion();
  for (int i = 0; i < 100000; ++i)
    q = cayley_update(q, {0.01, -0.02, 0.03});
  EXPECT_NEAR(q.norm(), 1.0, 3e-16);
}

TEST(Rotation, ExponentialRodriguesAndRotationVectorAgree) {
  std::mt19937 random(5);
  for (const double angle : {0.0, 1e-12, 1e-5, 9.9e-5, 1.1e-4, 0.3, 2.0, PI - 1e-9}) {
    const Vec3 v = angle * random_vector(random).normalized();
    const Vec4 q = quaternion_exponential(v);
    EXPECT_NEAR(q.norm(), 1.0, 1e-15);
    EXPECT_LE((rotation_matrix(q) - rodrigues(v)).norm(), 3e-15);
    EXPECT_LE((rotation_vector(q) - v).norm(), 2e-15 * (1.0 + angle));
    EXPECT_LE((rotation_vector(-q) - v).norm(), 2e-15 * (1.0 + angle));
  }
}

TEST(Rotation, DistanceKeepsTheDigitsOfSmallAngles) {
  const Vec4 q = quaternion_exponential({1e-10, 0.0, 0.0});
  EXPECT_NEAR(rotation_distance(identity_quaternion(), q), 1e-10, 1e-25);
  EXPECT_NEAR(rotation_distance(identity_quaternion(), -q), 1e-10, 1e-25);
}

TEST(Rotation, PolarRotationIsTheNearestAndNeverMirrors) {
  std::mt19937 random(6);
  for (int i = 0; i < 20; ++i) {
    const Mat3 R = rotation_matrix(random_quaternion(random));
    const Mat3 Q = rotation_matrix(random_quaternion(random));
    const Vec3 stretches(1.5, 0.9, i % 2 == 0 ? 0.4 : -0.4);
    const Mat3 U = Q * stretches.asDiagonal() * Q.transpose();
    EXPECT_LE((polar_rotation(R * U) - R).norm(), 1e-14);
  }
}

TEST(RotationVectors, DistancesAndSphericalAveragesAreThoseOfTheReference) {
  int distances = 0, averages = 0;
  double worst_distance = 0.0, worst_average = 0.0;
  for (const json& vector : test::all_vectors()) {
    if (vector.value("kind", "") != "scalars")
      continue;
    for (const json& entry : vector.value("qdist", json::array())) {
      const double distance = rotation_distance(quaternion(entry.at("a")), quaternion(entry.at("b")));
      worst_distance = std::max(worst_distance, std::abs(distance - entry.at("dist").get<double>()));
      ++distances;
    }
    for (const json& entry : vector.value("spherical_average", json::array())) {
      std::vector<Vec4> rotations;
      for (const json& q : entry.at("q"))
        rotations.push_back(quaternion(q));
      const auto weights = entry.at("w").get<std::vector<double>>();
      const Vec4 average = spherical_average(rotations, weights);
      worst_average = std::max(worst_average, (average - quaternion(entry.at("avg"))).cwiseAbs().maxCoeff());
      ++averages;
    }
  }
  std::printf("scalars: %d distances, worst error %.2g; %d spherical averages, worst error %.2g\n", distances,
              worst_distance, averages, worst_average);
  EXPECT_GE(distances, 4);
  EXPECT_GE(averages, 3);
  EXPECT_LE(worst_distance, 1e-13);
  EXPECT_LE(worst_average, 1e-13);
}

} // namespace
} // namespace wry
