#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "sim/mpm/grains/grain_kernels.h"
#include "sim/mpm/matter/orientation.h"
#include "tests/runnable_isas.h"

namespace wry::mpm {
namespace {

constexpr double CELL = 0.02;

struct Grain {
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero(), spin = Vec3::Zero();
  Vec4 orientation = identity_quaternion();
  double own = 0.0;
  bool carried = false;
};

void put(const Grain& grain, int lane, GrainBatch& batch) {
  for (int k = 0; k < 3; ++k) {
    batch.position[k][lane] = grain.position[k];
    batch.velocity[k][lane] = grain.velocity[k];
    batch.spin[k][lane] = grain.spin[k];
  }
  for (int k = 0; k < 4; ++k)
    batch.orientation[k][lane] = grain.orientation[k];
  batch.own[lane] = grain.own;
}

Grain take(const GrainBatch& batch, int lane) {
  Grain grain;
  for (int k = 0; k < 3; ++k) {
    grain.position[k] = batch.position[k][lane];
    grain.velocity[k] = batch.velocity[k][lane];
    grain.spin[k] = batch.spin[k][lane];
  }
  for (int k = 0; k < 4; ++k)
    grain.orientation[k] = batch.orientation[k][lane];
  grain.carried = batch.carried[lane];
  return grain;
}

/// Nodes of the block at (2, -3, 5) in a linear flow; those for which `has_matter` is false have none.
struct Flow {
  Vec3 drift{0.3, -0.2, 0.1};
  Mat3 gradient = Mat3::Zero();
  bool (*has_matter)(int x, int y, int z) = [](int, int, int) { return true; };

  Vec3 at(const Vec3& point) const { return drift + gradient * point; }
};
constexpr int BLOCK[3] = {2, -3, 5};
constexpr double FULL = 0.008; // kg

Vec3 node_position(int node) {
  const int at[3] = {node / (HALO_SIDE * HALO_SIDE), node / HALO_SIDE % HALO_SIDE, node % HALO_SIDE};
  Vec3 position;
  for (int k = 0; k < 3; ++k)
    position[k] = CELL * (BLOCK_SIDE * BLOCK[k] + at[k] - 1);
  return position;
}

bool has_matter(const Flow& flow, int node) {
  return flow.has_matter(node / (HALO_SIDE * HALO_SIDE), node / HALO_SIDE % HALO_SIDE, node % HALO_SIDE);
}

std::unique_ptr<FlowNodes> nodes_of(const Flow& flow, Isa isa) {
  std::vector<float> halo(HALO_VALUES, 0.0F);
  for (int node = 0; node < HALO_NODES; ++node) {
    if (!has_matter(flow, node))
      continue;
    const Vec3 velocity = flow.at(node_position(node));
    for (int k = 0; k < 3; ++k)
      halo[static_cast<std::size_t>(node * NODE_VALUES + k)] = static_cast<float>(velocity[k]);
    halo[static_cast<std::size_t>(node * NODE_VALUES + 3)] = static_cast<float>(0.9 * FULL);
  }
  auto nodes = std::make_unique<FlowNodes>();
  nodes->cell = CELL;
  for (int k = 0; k < 3; ++k)
    nodes->origin[k] = BLOCK_SIDE * BLOCK[k];
  grain_kernels(isa).shape_flow_float(halo.data(), FULL, 0.005, *nodes);
  return nodes;
}

std::vector<Grain> random_grains(int count, unsigned seed) {
  std::mt19937 dice(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  std::vector<Grain> grains(static_cast<std::size_t>(count));
  for (Grain& grain : grains) {
    for (int k = 0; k < 3; ++k) {
      grain.position[k] = CELL * (BLOCK_SIDE * BLOCK[k] + 0.6 + 3.8 * uniform(dice));
      grain.velocity[k] = 0.3 * normal(dice);
    }
    grain.orientation = Vec4(normal(dice), normal(dice), normal(dice), normal(dice)).normalized();
  }
  return grains;
}

Mat3 random_gradient(unsigned seed, double size) {
  std::mt19937 dice(seed);
  std::normal_distribution<double> normal;
  Mat3 L;
  for (int i = 0; i < 9; ++i)
    L(i / 3, i % 3) = normal(dice);
  return size / L.norm() * L;
}

std::vector<Grain> carry(const std::vector<Grain>& grains, const FlowNodes& nodes, const GrainMotion& motion, Isa isa) {
  GrainBatch batch;
  std::memset(static_cast<void*>(&batch), 0xFF, sizeof batch); // no lane without a grain may matter
  const int count = static_cast<int>(grains.size());
  for (int lane = 0; lane < count; ++lane)
    put(grains[static_cast<std::size_t>(lane)], lane, batch);
  grain_kernels(isa).carry(nodes, motion, count, batch);
  std::vector<Grain> after;
  for (int lane = 0; lane < count; ++lane)
    after.push_back(take(batch, lane));
  return after;
}

class GrainKernels : public testing::TestWithParam<Isa> {};
INSTANTIATE_TEST_SUITE_P(Each, GrainKernels, testing::ValuesIn(test::runnable_isas()),
                         [](const auto& set) { return std::string(isa_name(set.param)); });

TEST_P(GrainKernels, CarryGrainsWithTheMidpointOfALinearFlow) {
  for (const double turn : {1e-6, 1e-3, 0.03, 0.25, 0.7}) {
    GrainMotion motion;
    motion.dt = 2e-3;
    motion.thinnest = 0.05;
    Flow flow;
    flow.gradient = random_gradient(7, turn / motion.dt);
    const auto nodes = nodes_of(flow, GetParam());
    std::vector<Grain> grains = random_grains(GRAINS_AT_ONCE, 3);
    grains[4].own = 0.5;
    const std::vector<Grain> after = carry(grains, *nodes, motion, GetParam());
    const double fastest = flow.drift.norm() + flow.gradient.norm();
    for (std::size_t i = 0; i < grains.size(); ++i) {
      ASSERT_TRUE(after[i].carried);
      const Vec3 there = flow.at(grains[i].position + 0.5 * motion.dt * grains[i].velocity);
      const Vec3 velocity = grains[i].own * grains[i].velocity + (1.0 - grains[i].own) * there;
      EXPECT_LT((after[i].velocity - velocity).norm(), 1e-6 * fastest);
      EXPECT_LT((after[i].position - grains[i].position - motion.dt * velocity).norm(), 1e-6 * motion.dt * fastest);
      const Vec3 spin = 0.5 * Vec3(flow.gradient(2, 1) - flow.gradient(1, 2), flow.gradient(0, 2) - flow.gradient(2, 0),
                                   flow.gradient(1, 0) - flow.gradient(0, 1));
      EXPECT_LT((after[i].spin - spin).norm(), 1e-4 * fastest); // a difference of velocities, over a cell
      const Vec4 wanted =
          quaternion_product(quaternion_of(frame_turn(flow.gradient, motion.dt)), grains[i].orientation);
      EXPECT_LT(rotation_distance(after[i].orientation, wanted), 3e-6 * (1.0 + fastest * motion.dt / CELL));
      EXPECT_NEAR(after[i].orientation.norm(), 1.0, 1e-14);
    }
  }
}

TEST_P(GrainKernels, TurnGrainsByJefferysEquation) {
  // Up to turns and stretches that no step of a simulation makes.
  for (const double turn : {1e-6, 1e-3, 0.03, 0.25, 0.7, 3.0, 20.0}) {
    for (const double shape : {jeffery_shape(5.0), jeffery_shape(0.1)}) {
      GrainMotion motion;
      motion.dt = 2e-3;
      motion.thinnest = 0.05;
      motion.turns_by_flow = true;
      motion.jeffery = shape;
      Flow flow;
      flow.gradient = random_gradient(11, turn / motion.dt);
      const auto nodes = nodes_of(flow, GetParam());
      const std::vector<Grain> grains = random_grains(GRAINS_AT_ONCE - 3, 5);
      const std::vector<Grain> after = carry(grains, *nodes, motion, GetParam());
      for (std::size_t i = 0; i < grains.size(); ++i) {
        const Vec3 before = rotation_matrix(grains[i].orientation).col(2);
        const Vec3 wanted = turn_direction(before, flow.gradient, shape, motion.dt);
        EXPECT_LT((rotation_matrix(after[i].orientation).col(2) - wanted).norm(), 3e-5 * (1.0 + turn)) << turn;
        EXPECT_NEAR(after[i].orientation.norm(), 1.0, 1e-14);
      }
    }
  }
}

TEST_P(GrainKernels, AGrainsAnswerDependsOnNoOtherGrain) {
  Flow flow;
  flow.gradient = random_gradient(23, 90.0);
  flow.has_matter = [](int x, int y, int z) { return x + y + z < 13; };
  const auto nodes = nodes_of(flow, GetParam());
  std::vector<Grain> grains = random_grains(GRAINS_AT_ONCE, 17);
  grains[2].position.setConstant(1e3); // so that it matters to nobody else
  for (const bool by_flow : {false, true}) {
    GrainMotion motion;
    motion.dt = 4e-3;
    motion.thinnest = 0.3;
    motion.turns_by_flow = by_flow;
    motion.jeffery = 0.9;
    const std::vector<Grain> together = carry(grains, *nodes, motion, GetParam());
    for (std::size_t i = 0; i < grains.size(); ++i) {
      const Grain alone = carry({grains[i]}, *nodes, motion, GetParam())[0];
      EXPECT_EQ(alone.carried, together[i].carried);
      EXPECT_EQ(alone.position, together[i].position);
      EXPECT_EQ(alone.velocity, together[i].velocity);
      EXPECT_EQ(alone.orientation, together[i].orientation);
    }
  }
}

/// The gradient by least squares over the nodes with matter, its second moment damped as the kernels do it.
Mat3 damped_gradient(const Flow& flow, const Vec3& point) {
  double sum = 0.0;
  Vec3 centre = Vec3::Zero(), velocity = Vec3::Zero();
  Mat3 moment = Mat3::Zero(), mixed = Mat3::Zero();
  for (int node = 0; node < HALO_NODES; ++node) {
    const Vec3 away = (node_position(node) - point) / CELL;
    if (!has_matter(flow, node) || away.cwiseAbs().maxCoeff() >= 1.5)
      continue;
    double weight = 1.0;
    for (int k = 0; k < 3; ++k) {
      const double d = std::abs(away[k]);
      weight *= d < 0.5 ? 0.75 - d * d : 0.5 * (1.5 - d) * (1.5 - d);
    }
    const Vec3 there = flow.at(node_position(node));
    sum += weight;
    centre += weight * away;
    velocity += weight * there;
    moment += weight * away * away.transpose();
    mixed += weight * there * away.transpose();
  }
  centre /= sum;
  velocity /= sum;
  const Mat3 K = moment / sum - centre * centre.transpose();
  const Mat3 slope = 4.0 / CELL * (mixed / sum - velocity * centre.transpose());
  if (sum > 0.999)
    return slope;
  return slope * ((4.0 * K + 0.05 * Mat3::Identity()) / 1.05).inverse();
}

TEST_P(GrainKernels, AtASurfaceOnlyNodesWithMatterCount) {
  Flow flow;
  flow.gradient = random_gradient(29, 20.0);
  flow.has_matter = [](int x, int y, int z) { return 2 * x - y + z < 7; };
  const auto nodes = nodes_of(flow, GetParam());
  GrainMotion motion;
  motion.dt = 1e-3;
  motion.thinnest = 0.05;
  int at_surface = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const std::vector<Grain> grains = random_grains(GRAINS_AT_ONCE, seed);
    const std::vector<Grain> after = carry(grains, *nodes, motion, GetParam());
    for (std::size_t i = 0; i < grains.size(); ++i) {
      if (!after[i].carried)
        continue;
      const Mat3 L = damped_gradient(flow, grains[i].position + 0.5 * motion.dt * grains[i].velocity);
      const Vec4 wanted = quaternion_product(quaternion_of(frame_turn(L, motion.dt)), grains[i].orientation);
      EXPECT_LT(rotation_distance(after[i].orientation, wanted), 2e-5);
      at_surface += (L - flow.gradient).norm() > 1.0 ? 1 : 0;
    }
  }
  EXPECT_GT(at_surface, 20);
}

TEST_P(GrainKernels, ThinMatterCarriesNothingAndLeavesGrainsAsTheyAre) {
  Flow flow;
  flow.gradient = random_gradient(31, 20.0);
  flow.has_matter = [](int x, int, int) { return x == 3; };
  const auto nodes = nodes_of(flow, GetParam());
  EXPECT_EQ(nodes->least_density, 0.0F);
  GrainMotion motion;
  motion.dt = 1e-3;
  int carried = 0, left = 0;
  for (const double thinnest : {0.05, 0.5}) {
    motion.thinnest = thinnest;
    const std::vector<Grain> grains = random_grains(GRAINS_AT_ONCE, 37);
    const std::vector<Grain> after = carry(grains, *nodes, motion, GetParam());
    for (std::size_t i = 0; i < grains.size(); ++i) {
      const Vec3 point = grains[i].position + 0.5 * motion.dt * grains[i].velocity;
      const double d = std::abs(point.x() / CELL - (BLOCK_SIDE * BLOCK[0] + 2));
      const double share = 0.9 * (d < 0.5 ? 0.75 - d * d : d < 1.5 ? 0.5 * (1.5 - d) * (1.5 - d) : 0.0);
      ASSERT_GT(std::abs(share - thinnest), 1e-6);
      EXPECT_EQ(after[i].carried, share > thinnest);
      if (after[i].carried) {
        ++carried;
        continue;
      }
      ++left;
      EXPECT_EQ(after[i].position, grains[i].position);
      EXPECT_EQ(after[i].velocity, grains[i].velocity);
      EXPECT_EQ(after[i].orientation, grains[i].orientation);
    }
  }
  EXPECT_GT(carried, 3);
  EXPECT_GT(left, 10);
}

TEST_P(GrainKernels, DoublesAreSeenAsASnapshotOfTheGridHasThem) {
  std::mt19937 dice(41);
  std::normal_distribution<double> normal;
  std::vector<double> exact(HALO_VALUES);
  std::vector<float> rounded;
  for (double& value : exact)
    value = std::abs(1e-3 * normal(dice));
  for (const double value : exact)
    rounded.push_back(static_cast<float>(value));
  auto first = std::make_unique<FlowNodes>(), second = std::make_unique<FlowNodes>();
  grain_kernels(GetParam()).shape_flow_double(exact.data(), 1.7e-3, 0.4, *first);
  grain_kernels(GetParam()).shape_flow_float(rounded.data(), 1.7e-3, 0.4, *second);
  EXPECT_EQ(0, std::memcmp(first->flow, second->flow, sizeof first->flow));
  EXPECT_EQ(0, std::memcmp(first->density, second->density, sizeof(float) * HALO_NODES));
  EXPECT_EQ(first->least_density, second->least_density);
}

} // namespace
} // namespace wry::mpm
