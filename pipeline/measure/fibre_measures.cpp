#include "pipeline/measure/fibre_measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include <Eigen/Eigenvalues>

#include "pipeline/measure/pile_measures.h"
#include "sim/base/rotation.h"

namespace wry::pipeline {

namespace {

constexpr double NOTHING = std::numeric_limits<double>::quiet_NaN();

template <class Visit> void for_rows(const MeasurePlan& plan, std::size_t rows, const Visit& visit) {
  if (plan.nodes.empty()) {
    for (std::size_t i = 0; i < rows; ++i)
      visit(i);
    return;
  }
  for (const std::int32_t i : plan.nodes)
    visit(static_cast<std::size_t>(i));
}

/// The second moment of each particle's grains, in the world; no particle has one without axes.
template <class Visit> void for_moments(const MeasurePlan& plan, const FrameBody& frame, const Visit& visit) {
  if (const Channel* moments = find_channel(frame, "second_moment")) {
    for_rows(plan, moments->values.size() / 6, [&](std::size_t i) {
      const double* m = moments->values.data() + 6 * i; // xx yy zz yz zx xy
      Mat3 moment;
      moment << m[0], m[5], m[4], m[5], m[1], m[3], m[4], m[3], m[2];
      visit(i, moment);
    });
  } else if (const Channel* frames = find_channel(frame, "orientation")) {
    for_rows(plan, frames->values.size() / 4, [&](std::size_t i) {
      const double* q = frames->values.data() + 4 * i;
      const Vec3 fibre = rotation_matrix(Vec4(q[0], q[1], q[2], q[3]).normalized()).col(2);
      visit(i, Mat3(fibre * fibre.transpose()));
    });
  }
}

/// The mean over the particles; not finite without axes.
Mat3 mean_second_moment(const MeasurePlan& plan, const FrameBody& frame) {
  Mat3 sum = Mat3::Zero();
  double count = 0.0;
  for_moments(plan, frame, [&](std::size_t, const Mat3& moment) {
    sum += moment;
    count += 1.0;
  });
  return sum / count;
}

using Cell = std::array<std::int64_t, 3>;

std::size_t root_of(std::vector<std::size_t>& parent, std::size_t i) {
  while (parent[i] != i) {
    parent[i] = parent[parent[i]];
    i = parent[i];
  }
  return i;
}

} // namespace

namespace {

/// Of what moves, against its own velocity.
double alignment_with_flow(const MeasurePlan& plan, const FrameBody& frame) {
  constexpr double STILL = 1e-3; // [m/s]
  const PointMap velocities = point_channel(frame, "velocity");
  double sum = 0.0, count = 0.0;
  for_moments(plan, frame, [&](std::size_t i, const Mat3& moment) {
    const Vec3 velocity = velocities.row(static_cast<Eigen::Index>(i));
    if (velocity.norm() < STILL)
      return;
    sum += velocity.dot(moment * velocity) / velocity.squaredNorm();
    count += 1.0;
  });
  return sum / count;
}

} // namespace

double mean_alignment(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  if (plan.direction.isZero())
    return alignment_with_flow(plan, frame);
  return plan.direction.dot(mean_second_moment(plan, frame) * plan.direction);
}

double second_moment(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  const Mat3 moment = mean_second_moment(plan, frame);
  return moment.allFinite() ? Eigen::SelfAdjointEigenSolver<Mat3>(moment).eigenvalues()[2] : NOTHING;
}

double largest_fragment(const MeasurePlan& plan, const SceneBody&, const FrameBody& frame) {
  const PointMap points = point_channel(frame, "position");
  if (points.rows() == 0 || !(plan.cell > 0.0))
    return NOTHING;
  std::map<Cell, std::size_t> index;
  std::vector<double> particles;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    Cell cell;
    for (int axis = 0; axis < 3; ++axis)
      cell[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(std::floor(points(i, axis) / plan.cell));
    const std::size_t place = index.emplace(cell, index.size()).first->second;
    particles.resize(index.size(), 0.0);
    particles[place] += 1.0;
  }
  std::vector<std::size_t> parent(index.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  for (const auto& [cell, place] : index) {
    for (int n = 0; n < 13; ++n) { // half of the neighbours: the other half finds this cell
      const auto found = index.find({cell[0] + n / 9 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n % 3 - 1});
      if (found != index.end())
        parent[root_of(parent, place)] = root_of(parent, found->second);
    }
  }
  std::vector<double> pieces(index.size(), 0.0);
  for (std::size_t i = 0; i < parent.size(); ++i)
    pieces[root_of(parent, i)] += particles[i];
  return *std::max_element(pieces.begin(), pieces.end()) / static_cast<double>(points.rows());
}

} // namespace wry::pipeline
