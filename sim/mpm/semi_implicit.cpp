#include "sim/mpm/semi_implicit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace wry::mpm {

namespace {

constexpr std::size_t GRAIN = 16; // blocks
constexpr int MOST_ITERATIONS = 500;

/// Calls visit(offset of the node's values) for the nodes of a block that have mass.
template <class Scalar, class Visit> void for_nodes(const Scalar* grid_values, const Visit& visit) {
  for (int node = 0; node < BLOCK_VALUES; node += NODE_VALUES) {
    if (grid_values[node + 3] > 0)
      visit(node);
  }
}

} // namespace

template <class Scalar> void SemiImplicitSolver<Scalar>::fit(std::size_t blocks) {
  m_blocks = blocks;
  for (AlignedVector<Scalar>* vector : {&m_start, &m_velocity, &m_residual, &m_direction, &m_image})
    vector->resize(blocks * BLOCK_VALUES);
  m_constraints.resize(blocks);
  for (std::vector<NodeConstraint>& constraints : m_constraints)
    constraints.clear();
  m_sums.resize(blocks);
}

template <class Scalar> void SemiImplicitSolver<Scalar>::project(std::size_t block, Scalar* vector) const {
  for (const NodeConstraint& constraint : m_constraints[block]) {
    Scalar* value = vector + block * BLOCK_VALUES + constraint.node * NODE_VALUES;
    const Vec3 before(value[0], value[1], value[2]);
    Vec3 after = Vec3::Zero();
    if (constraint.kind != NodeConstraint::Kind::all) {
      const Vec3 along = before.dot(constraint.direction) * constraint.direction;
      after = constraint.kind == NodeConstraint::Kind::along ? along : Vec3(before - along);
    }
    for (int axis = 0; axis < 3; ++axis)
      value[axis] = static_cast<Scalar>(after[axis]);
  }
}

template <class Scalar>
double SemiImplicitSolver<Scalar>::sum_blocks(const Threads& threads,
                                              const std::function<double(std::size_t)>& of_block) {
  threads.for_each(m_blocks, GRAIN, [&](std::size_t block) { m_sums[block] = of_block(block); });
  double sum = 0.0;
  for (const double part : m_sums)
    sum += part;
  return sum;
}

template <class Scalar>
SolveReport SemiImplicitSolver<Scalar>::solve(Grid<Scalar>& grid, double dt, const Vec3& gravity,
                                              const SemiImplicit& settings, const Stiffness& stiffness,
                                              const Threads& threads) {
  const Scalar weight = static_cast<Scalar>(settings.implicitness * dt * dt);
  const Scalar kept = static_cast<Scalar>(1.0 - settings.damping);
  const auto at = [](AlignedVector<Scalar>& vector, std::size_t block) { return vector.data() + block * BLOCK_VALUES; };

  // From free flight: what conjugate gradients have not reached yet answers the forces too little. From the explicit
  // step it would answer them too much, and grow.
  const double squared_momentum = sum_blocks(threads, [&](std::size_t block) {
    const Scalar* values = grid.values(block);
    const Scalar* start = at(m_start, block);
    Scalar* velocity = at(m_velocity, block);
    Scalar* direction = at(m_direction, block);
    Scalar* residual = at(m_residual, block);
    for (Scalar* vector : {velocity, direction, residual})
      std::fill(vector, vector + BLOCK_VALUES, Scalar(0));
    double sum = 0.0;
    for_nodes(values, [&](int node) {
      const Scalar mass = values[node + 3];
      for (int axis = 0; axis < 3; ++axis) {
        const Scalar before = start[node + axis] / mass;
        residual[node + axis] = values[node + axis] - (before + static_cast<Scalar>(dt * gravity[axis]));
        sum += static_cast<double>(mass) * static_cast<double>(before) * static_cast<double>(before);
      }
    });
    project(block, m_residual.data()); // contact prescribes the rest
    for_nodes(values, [&](int node) {
      const Scalar mass = values[node + 3];
      for (int axis = 0; axis < 3; ++axis) {
        velocity[node + axis] = values[node + axis] - residual[node + axis];
        direction[node + axis] = velocity[node + axis] - kept * (start[node + axis] / mass);
        residual[node + axis] *= mass;
      }
    });
    return sum;
  });
  stiffness(m_direction.data(), m_image.data());

  const auto squared_residual = [&](std::size_t block) {
    const Scalar* residual = at(m_residual, block);
    double sum = 0.0;
    for_nodes(grid.values(block), [&](int node) {
      for (int axis = 0; axis < 3; ++axis) {
        const double r = residual[node + axis];
        sum += r * r / static_cast<double>(grid.values(block)[node + 3]);
      }
    });
    return sum;
  };
  const double first = sum_blocks(threads, [&](std::size_t block) {
    Scalar* residual = at(m_residual, block);
    const Scalar* image = at(m_image, block);
    for (int i = 0; i < BLOCK_VALUES; ++i)
      residual[i] -= weight * image[i];
    project(block, m_residual.data());
    return squared_residual(block);
  });
  // Below round-off of the momentum itself there is nothing to be solved.
  const double noise = std::numeric_limits<Scalar>::epsilon();
  SolveReport report;
  double left = first > noise * noise * squared_momentum ? first : 0.0;
  double ratio = 0.0; // of the old direction that is kept
  while (report.iterations < MOST_ITERATIONS && left > settings.tolerance * settings.tolerance * first && left > 0.0) {
    threads.for_each(m_blocks, GRAIN, [&](std::size_t block) {
      const Scalar* values = grid.values(block);
      const Scalar* residual = at(m_residual, block);
      Scalar* direction = at(m_direction, block);
      for_nodes(values, [&](int node) {
        const Scalar inverse = Scalar(1) / values[node + 3];
        for (int axis = 0; axis < 3; ++axis) {
          const Scalar old = ratio > 0.0 ? static_cast<Scalar>(ratio) * direction[node + axis] : Scalar(0);
          direction[node + axis] = inverse * residual[node + axis] + old;
        }
      });
    });
    stiffness(m_direction.data(), m_image.data());
    const double curvature = sum_blocks(threads, [&](std::size_t block) {
      const Scalar* values = grid.values(block);
      Scalar* direction = at(m_direction, block);
      Scalar* image = at(m_image, block);
      double sum = 0.0;
      for_nodes(values, [&](int node) {
        for (int axis = 0; axis < 3; ++axis) {
          const int i = node + axis;
          image[i] = values[node + 3] * direction[i] + weight * image[i];
          sum += static_cast<double>(direction[i]) * static_cast<double>(image[i]);
        }
      });
      return sum;
    });
    const Scalar step = static_cast<Scalar>(left / curvature);
    const double next = sum_blocks(threads, [&](std::size_t block) {
      Scalar* velocity = at(m_velocity, block);
      Scalar* residual = at(m_residual, block);
      const Scalar* direction = at(m_direction, block);
      project(block, m_image.data());
      const Scalar* image = at(m_image, block);
      for_nodes(grid.values(block), [&](int node) {
        for (int axis = 0; axis < 3; ++axis) {
          velocity[node + axis] += step * direction[node + axis];
          residual[node + axis] -= step * image[node + axis];
        }
      });
      return squared_residual(block);
    });
    ++report.iterations;
    ratio = next / left;
    left = next;
  }
  threads.for_each(m_blocks, GRAIN, [&](std::size_t block) {
    Scalar* values = grid.values(block);
    const Scalar* velocity = at(m_velocity, block);
    for_nodes(values, [&](int node) { std::copy(velocity + node, velocity + node + 3, values + node); });
  });
  report.residual = first > 0.0 ? std::sqrt(left / first) : 0.0;
  return report;
}

template <class Scalar> std::size_t SemiImplicitSolver<Scalar>::memory_bytes() const {
  return 5 * m_start.capacity() * sizeof(Scalar);
}

template class SemiImplicitSolver<float>;
template class SemiImplicitSolver<double>;

} // namespace wry::mpm
