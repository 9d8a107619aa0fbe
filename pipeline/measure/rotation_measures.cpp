#include "pipeline/measure/rotation_measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>

#include "sim/base/rotation.h"
#include "sim/fem/rotation_interpolation.h"

namespace wry::pipeline {

namespace {

constexpr double NOT_THERE = std::numeric_limits<double>::quiet_NaN();
constexpr double DEGREES = 180.0 / std::numbers::pi;

/// The rows of a channel, or none.
struct Rows {
  const double* data = nullptr;
  Eigen::Index count = 0;
  int components = 0;
};

Rows rows_of(const FrameBody& frame, const char* name) {
  const Channel* channel = find_channel(frame, name);
  if (channel == nullptr)
    return {};
  return {channel->values.data(), static_cast<Eigen::Index>(channel->values.size()) / channel->components,
          channel->components};
}

Vec4 quaternion_at(const Rows& rows, Eigen::Index index) {
  return Eigen::Map<const Vec4>(rows.data + 4 * index).normalized();
}

/// An element: its corners' microrotations, shape gradients and deformation.
struct Element {
  std::array<Vec4, 4> rotations;
  Eigen::Matrix<double, 4, 3> gradients;
  Mat3 F;
  double volume = 0.0;
};

/// What all measures of elements read.
struct Field {
  const SceneBody& body;
  Rows positions, rotations, points;

  explicit Field(const SceneBody& scene_body, const FrameBody& frame)
      : body(scene_body)
      , positions(rows_of(frame, "position"))
      , rotations(rows_of(frame, "microrotation"))
      , points(rows_of(frame, "point_rotation")) {}

  bool whole() const { return positions.data != nullptr && rotations.data != nullptr && body.tets.rows() > 0; }

  Element element(Eigen::Index tet) const {
    Element out;
    Mat3 rest, now;
    const auto place = [&](int k) { return Vec3(Eigen::Map<const Vec3>(positions.data + 3 * body.tets(tet, k))); };
    for (int k = 0; k < 4; ++k)
      out.rotations[k] = quaternion_at(rotations, body.tets(tet, k));
    for (int k = 0; k < 3; ++k) {
      rest.col(k) = body.rest_positions.row(body.tets(tet, k + 1)) - body.rest_positions.row(body.tets(tet, 0));
      now.col(k) = place(k + 1) - place(0);
    }
    const Mat3 inverse = rest.inverse();
    out.gradients.bottomRows<3>() = inverse;
    out.gradients.row(0) = -inverse.colwise().sum();
    out.F = now * inverse;
    out.volume = rest.determinant() / 6.0;
    return out;
  }

  /// The rotation that the solver carries at a quadrature point, its sign that of the corners.
  Vec4 point(Eigen::Index tet, int k, const Element& element) const {
    const Vec4 q = quaternion_at(points, 4 * tet + k);
    return q.dot(element.rotations[k]) < 0.0 ? Vec4(-q) : q;
  }
};

double distance_to_matter(const Vec4& rotation, const Mat3& F) {
  return wry::rotation_distance(rotation, quaternion_of(polar_rotation(F)));
}

double distance_at_nodes(const Field& field) {
  std::vector<Mat3> sums(static_cast<std::size_t>(field.rotations.count), Mat3::Zero());
  std::vector<double> volumes(sums.size(), 0.0);
  for (Eigen::Index tet = 0; tet < field.body.tets.rows(); ++tet) {
    const Element element = field.element(tet);
    for (int k = 0; k < 4; ++k) {
      const auto node = static_cast<std::size_t>(field.body.tets(tet, k));
      sums[node] += element.volume * element.F;
      volumes[node] += element.volume;
    }
  }
  double sum = 0.0;
  int count = 0;
  for (std::size_t node = 0; node < sums.size(); ++node) {
    if (volumes[node] == 0.0)
      continue;
    sum += distance_to_matter(quaternion_at(field.rotations, static_cast<Eigen::Index>(node)), sums[node]);
    ++count;
  }
  return sum / count;
}

/// The mean over elements, weighted by volume.
template <class Visit> double mean_over_elements(const Field& field, const Visit& visit) {
  double sum = 0.0, volume = 0.0;
  for (Eigen::Index tet = 0; tet < field.body.tets.rows(); ++tet) {
    const Element element = field.element(tet);
    sum += element.volume * visit(tet, element);
    volume += element.volume;
  }
  return sum / volume;
}

/// Calls visit(tet, element, weights, k) for all quadrature points.
template <class Visit> void for_points(const Field& field, const Visit& visit) {
  const Eigen::Matrix4d all = fem::quadrature_weights();
  for (Eigen::Index tet = 0; tet < field.body.tets.rows(); ++tet) {
    const Element element = field.element(tet);
    for (int k = 0; k < 4; ++k) {
      const Vec4 weights = all.row(k);
      visit(tet, element, std::span<const double>(weights.data(), 4), k);
    }
  }
}

} // namespace

double element_twist_max(const MeasurePlan&, const SceneBody& body, const FrameBody& frame) {
  const Field field(body, frame);
  if (!field.whole())
    return NOT_THERE;
  double most = 0.0;
  for (Eigen::Index tet = 0; tet < body.tets.rows(); ++tet) {
    const Element element = field.element(tet);
    for (int k = 0; k < 4; ++k) {
      for (int l = k + 1; l < 4; ++l)
        most = std::max(most, wry::rotation_distance(element.rotations[k], element.rotations[l]));
    }
  }
  return most * DEGREES;
}

double rotation_distance(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame) {
  const Field field(body, frame);
  if (!field.whole() || (plan.at == shots::MeasureAt::points && field.points.data == nullptr))
    return NOT_THERE;
  switch (plan.at) {
  case shots::MeasureAt::nodes:
    return distance_at_nodes(field) * DEGREES;
  case shots::MeasureAt::points:
    return DEGREES * mean_over_elements(field, [&](Eigen::Index tet, const Element& element) {
             const Vec4 matter = quaternion_of(polar_rotation(element.F));
             double sum = 0.0;
             for (int k = 0; k < 4; ++k)
               sum += wry::rotation_distance(field.point(tet, k, element), matter);
             return 0.25 * sum;
           });
  case shots::MeasureAt::centroid:
    return DEGREES * mean_over_elements(field, [&](Eigen::Index, const Element& element) {
             constexpr std::array QUARTERS = {0.25, 0.25, 0.25, 0.25};
             return distance_to_matter(spherical_average(element.rotations, QUARTERS), element.F);
           });
  }
  return NOT_THERE;
}

double curvature_error(const MeasurePlan&, const SceneBody& body, const FrameBody& frame) {
  const Field field(body, frame);
  if (!field.whole() || field.points.data == nullptr)
    return NOT_THERE;
  double worst = 0.0;
  for_points(field, [&](Eigen::Index tet, const Element& element, std::span<const double> weights, int k) {
    const Mat3 exact = fem::spherical_wryness(element.rotations, weights, element.gradients);
    const Mat3 error = fem::wryness(field.point(tet, k, element), element.rotations, element.gradients) - exact;
    if (const double scale = exact.norm(); scale > 0.0)
      worst = std::max(worst, error.norm() / scale);
  });
  return worst;
}

double rotation_interpolation_error(const MeasurePlan& plan, const SceneBody& body, const FrameBody& frame) {
  const Field field(body, frame);
  const bool history = plan.rule == shots::PointRotations::velocity;
  if (!field.whole() || (history && field.points.data == nullptr))
    return NOT_THERE;
  const fem::PointRotations rule = plan.rule == shots::PointRotations::rotation_vectors
                                       ? fem::PointRotations::rotation_vectors
                                       : fem::PointRotations::quaternion_blend;
  double worst = 0.0;
  for_points(field, [&](Eigen::Index tet, const Element& element, std::span<const double> weights, int k) {
    const Vec4 exact = spherical_average(element.rotations, weights);
    const Vec4 q = history ? field.point(tet, k, element) : fem::interpolate_rotation(rule, element.rotations, weights);
    worst = std::max(worst, wry::rotation_distance(q, exact));
  });
  return worst * DEGREES;
}

namespace {

constexpr int STATIONS = 13; ///< along the middle half

/// Where a slender body is at a place along its rest axis, and how it is turned there.
struct Station {
  Vec3 place = Vec3::Zero();
  Mat3 turn = Mat3::Identity();
};

/// The axis of the rest shape.
struct RestAxis {
  int along = 0;
  Vec3 low, high;
  double length() const { return (high - low)[along]; }
};

RestAxis rest_axis_of(const Points& rest) {
  RestAxis axis;
  axis.low = rest.colwise().minCoeff();
  axis.high = rest.colwise().maxCoeff();
  (axis.high - axis.low).maxCoeff(&axis.along);
  return axis;
}

/// The motion of the nodes within `reach` of `s`, fitted by an axis that is quadratic along the rod and cross-sections
/// that turn linearly: what a rod bent and twisted at a constant rate is, but for terms of fourth order in the angle
/// that the fit spans. Nothing when there are too few nodes to tell.
std::optional<Station> station_at(const Points& rest, const Rows& positions, const RestAxis& axis, double s,
                                  double reach) {
  std::vector<Eigen::Index> nodes;
  for (Eigen::Index node = 0; node < rest.rows(); ++node) {
    if (std::abs(rest(node, axis.along) - s) <= reach)
      nodes.push_back(node);
  }
  constexpr int TERMS = 7;
  if (nodes.size() < TERMS)
    return std::nullopt;
  const int second = (axis.along + 1) % 3, third = (axis.along + 2) % 3;
  Eigen::MatrixXd terms(nodes.size(), TERMS), places(nodes.size(), 3);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Vec3 from = rest.row(nodes[k]).transpose() - 0.5 * (axis.low + axis.high);
    const double t = (rest(nodes[k], axis.along) - s) / reach;
    const double y = from[second] / reach, z = from[third] / reach;
    const auto row = static_cast<Eigen::Index>(k);
    terms.row(row) << 1.0, t, t * t, y, z, t * y, t * z;
    places.row(row) = Eigen::Map<const Eigen::RowVector3d>(positions.data + 3 * nodes[k]);
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver(terms);
  solver.setThreshold(1e-6);
  if (solver.rank() < TERMS)
    return std::nullopt;
  const Eigen::MatrixXd fit = solver.solve(places);
  Mat3 frame;
  frame.col(axis.along) = fit.row(1);
  frame.col(second) = fit.row(3);
  frame.col(third) = fit.row(4);
  return Station{fit.row(0), polar_rotation(frame / reach)};
}

/// Stations of the middle half in order; empty when the body has too few nodes along it.
std::vector<Station> stations_of(const SceneBody& body, const Rows& positions) {
  const RestAxis axis = rest_axis_of(body.rest_positions);
  std::vector<Station> stations;
  for (int i = 0; i < STATIONS; ++i) {
    const double s = axis.low[axis.along] + (0.25 + 0.5 * i / (STATIONS - 1)) * axis.length();
    std::optional<Station> station;
    for (double reach = axis.length() / 48; !station && reach <= axis.length() / 6; reach *= 1.25)
      station = station_at(body.rest_positions, positions, axis, s, reach);
    if (!station)
      return {};
    stations.push_back(*station);
  }
  return stations;
}

struct Helix {
  double radius = NOT_THERE, pitch = NOT_THERE;
};

Helix helix_of(const SceneBody& body, const FrameBody& frame) {
  const Rows positions = rows_of(frame, "position");
  if (positions.data == nullptr)
    return {};
  const std::vector<Station> stations = stations_of(body, positions);
  if (stations.empty())
    return {};
  Helix sum{0.0, 0.0};
  for (std::size_t i = 0; i + 1 < stations.size(); ++i) {
    const Eigen::AngleAxisd turn(Mat3(stations[i + 1].turn * stations[i].turn.transpose()));
    const Vec3 way = stations[i + 1].place - stations[i].place;
    const double along = way.dot(turn.axis());
    sum.radius += (way - along * turn.axis()).norm() / (2.0 * std::sin(0.5 * turn.angle()));
    sum.pitch += std::abs(2.0 * std::numbers::pi * along / turn.angle());
  }
  const auto count = static_cast<double>(stations.size() - 1);
  return {sum.radius / count, sum.pitch / count};
}

} // namespace

double curve_radius(const MeasurePlan&, const SceneBody& body, const FrameBody& frame) {
  return helix_of(body, frame).radius;
}

double curve_pitch(const MeasurePlan&, const SceneBody& body, const FrameBody& frame) {
  return helix_of(body, frame).pitch;
}

} // namespace wry::pipeline
