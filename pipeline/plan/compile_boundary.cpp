#include "pipeline/plan/compile_boundary.h"

#include <algorithm>
#include <array>
#include <numbers>

#include <Eigen/Geometry>

#include "pipeline/plan/compile_collider.h"
#include "pipeline/plan/compile_fem.h"
#include "pipeline/plan/compile_fields.h"
#include "pipeline/plan/compile_region.h"
#include "sim/base/rotation.h"
#include "sim/scene/expression.h"

namespace wry::pipeline {

namespace {

Result<std::vector<std::int32_t>> pick(const shots::Region& where, const geometry::TetMesh& mesh,
                                       const shots::Source& source) {
  Result<std::vector<std::int32_t>> picked =
      scene::select_points(compile_region(where), scene::rest_points(mesh), Threads(1));
  if (!picked)
    return at_source(source, picked.error());
  return picked;
}

using Components = std::array<std::optional<shots::Located<shots::Expression>>, 3>;

/// A vector of three formulas of the time alone.
Result<std::function<Vec3(double)>> compile_vector(const Components& asked) {
  auto formulas = std::make_shared<std::array<std::optional<scene::Expression>, 3>>();
  bool any = false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!asked[i])
      continue;
    Result<scene::Expression> compiled = scene::Expression::compile(asked[i]->value.text);
    if (!compiled)
      return at_source(asked[i]->source, compiled.error());
    for (const char* name : {"X", "Y", "Z", "u", "v"}) {
      if (compiled->uses(name))
        return at_source(asked[i]->source, make_error(ErrorCode::bad_input,
                                                      "'{}' uses {}; a load is the same on all its nodes and may "
                                                      "depend on t only: pick nodes with where, or give more loads",
                                                      asked[i]->value.text, name));
    }
    if (const Result<double> probe = compiled->evaluate({}); !probe)
      return at_source(asked[i]->source, probe.error());
    (*formulas)[i] = std::move(*compiled);
    any = true;
  }
  if (!any)
    return std::function<Vec3(double)>();
  return std::function<Vec3(double)>([formulas](double time) {
    Vec3 value = Vec3::Zero();
    scene::ExpressionPoint point;
    point.time = time;
    for (std::size_t i = 0; i < 3; ++i) {
      if (!(*formulas)[i])
        continue;
      const Result<double> number = (*formulas)[i]->evaluate(point);
      // Not a number on purpose: the solver refuses a force that is not finite, with the time.
      value[static_cast<Eigen::Index>(i)] = number ? *number : std::numeric_limits<double>::quiet_NaN();
    }
    return value;
  });
}

std::vector<double> volume_shares(const geometry::TetMesh& mesh) {
  std::vector<double> shares(static_cast<std::size_t>(mesh.vertices.rows()), 0.0);
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    const auto edge = [&](int k) {
      return Vec3(mesh.vertices.row(mesh.tets(tet, k)) - mesh.vertices.row(mesh.tets(tet, 0)));
    };
    for (int k = 0; k < 4; ++k)
      shares[static_cast<std::size_t>(mesh.tets(tet, k))] += edge(1).cross(edge(2)).dot(edge(3)) / 24.0;
  }
  return shares;
}

/// Areas of the surface triangles whose corners are all picked, a third to each.
std::vector<double> area_shares(const geometry::TetMesh& mesh, const std::vector<std::int32_t>& nodes) {
  std::vector<double> shares(static_cast<std::size_t>(mesh.vertices.rows()), 0.0);
  const Triangles surface = geometry::boundary_triangles(mesh);
  for (Eigen::Index triangle = 0; triangle < surface.rows(); ++triangle) {
    const auto picked = [&](int k) { return std::binary_search(nodes.begin(), nodes.end(), surface(triangle, k)); };
    if (!picked(0) || !picked(1) || !picked(2))
      continue;
    const auto edge = [&](int k) {
      return Vec3(mesh.vertices.row(surface(triangle, k)) - mesh.vertices.row(surface(triangle, 0)));
    };
    for (int k = 0; k < 3; ++k)
      shares[static_cast<std::size_t>(surface(triangle, k))] += edge(1).cross(edge(2)).norm() / 6.0;
  }
  return shares;
}

} // namespace

Result<fem::DrivenNodes> compile_drive(const shots::Drive& drive, int body, const geometry::TetMesh& mesh,
                                       const std::vector<std::shared_ptr<const scene::Collider>>& colliders) {
  fem::DrivenNodes driven;
  driven.name = *drive.name;
  driven.body = body;
  driven.drive_positions = *drive.positions;
  driven.drive_microrotations = *drive.microrotations;
  driven.method = *drive.method == shots::DriveMethod::exact     ? fem::DriveMethod::exact
                  : *drive.method == shots::DriveMethod::penalty ? fem::DriveMethod::penalty
                                                                 : fem::DriveMethod::soft;
  driven.stiffness = *drive.stiffness;
  driven.turning_stiffness = *drive.turning_stiffness;
  if (drive.until)
    driven.until = **drive.until;
  Result<std::vector<std::int32_t>> picked = pick(drive.where, mesh, drive.source);
  if (!picked)
    return picked.error();
  driven.nodes = std::move(*picked);
  if (drive.collider) {
    const auto named = std::find_if(colliders.begin(), colliders.end(),
                                    [&](const auto& collider) { return collider->name == **drive.collider; });
    if ((*named)->sequence() != nullptr)
      return at_source(drive.collider->source, cannot_follow(**drive.collider));
    driven.motion = (*named)->motion;
    return driven;
  }
  Result<scene::Motion> motion = compile_motion(drive.motion);
  if (!motion)
    return motion.error();
  driven.motion = std::move(*motion);
  return driven;
}

Result<fem::FemLoad> compile_load(const shots::Load& load, int body, const geometry::TetMesh& mesh) {
  fem::FemLoad compiled;
  compiled.name = *load.name;
  compiled.body = body;
  if (load.where) {
    Result<std::vector<std::int32_t>> picked = pick(*load.where, mesh, load.source);
    if (!picked)
      return picked.error();
    compiled.nodes = std::move(*picked);
  } else {
    for (std::int32_t node = 0; node < mesh.vertices.rows(); ++node)
      compiled.nodes.push_back(node);
  }
  const bool per_area = *load.per == shots::LoadPer::area;
  const std::vector<double> shares = per_area ? area_shares(mesh, compiled.nodes) : volume_shares(mesh);
  double sum = 0.0;
  for (const std::int32_t node : compiled.nodes) {
    compiled.shares.push_back(shares[static_cast<std::size_t>(node)]);
    sum += compiled.shares.back();
  }
  if (!(sum > 0.0) && per_area)
    return at_source(load.source,
                     make_error(ErrorCode::bad_input,
                                "no triangle of the surface has all its corners in where; pick more nodes, "
                                "or use per = \"volume\""));
  if (!(sum > 0.0))
    return at_source(load.source, make_error(ErrorCode::bad_input, "the picked nodes have no volume"));
  if (*load.per == shots::LoadPer::whole) {
    for (double& share : compiled.shares)
      share /= sum;
  }
  Result<std::function<Vec3(double)>> force = compile_vector(load.force);
  if (!force)
    return force.error();
  Result<std::function<Vec3(double)>> torque = compile_vector(load.torque);
  if (!torque)
    return torque.error();
  compiled.force = std::move(*force);
  compiled.torque = std::move(*torque);
  return compiled;
}

Status compile_rest_rotation(const shots::Body& asked, fem::FemBody& body) {
  const geometry::TetMesh& mesh = *body.mesh;
  const scene::RestPoints vertices = scene::rest_points(mesh);
  const scene::RestPoints centres = tet_centres(mesh);
  Points at_vertices = Points::Zero(vertices.positions.rows(), 3);
  Points at_centres = Points::Zero(centres.positions.rows(), 3);
  bool any = false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!asked.rest_rotation[i])
      continue;
    any = true;
    const shots::Located<shots::Expression>& entry = *asked.rest_rotation[i];
    const Result<scene::Expression> compiled = compile_formula(entry, mesh);
    if (!compiled)
      return compiled.error();
    if (compiled->uses("t"))
      return at_source(entry.source, make_error(ErrorCode::bad_input, "'{}' depends on the time t; directors rest once",
                                                entry->text));
    const auto column = static_cast<Eigen::Index>(i);
    const Result<std::vector<double>> here = compiled->evaluate_all(vertices, 0.0, Threads(1));
    const Result<std::vector<double>> there = compiled->evaluate_all(centres, 0.0, Threads(1));
    if (!here || !there)
      return at_source(entry.source, !here ? here.error() : there.error());
    constexpr double RADIANS = std::numbers::pi / 180.0;
    at_vertices.col(column) = RADIANS * Eigen::Map<const Eigen::VectorXd>(here->data(), at_vertices.rows());
    at_centres.col(column) = RADIANS * Eigen::Map<const Eigen::VectorXd>(there->data(), at_centres.rows());
  }
  if (!any)
    return {};
  for (Eigen::Index vertex = 0; vertex < at_vertices.rows(); ++vertex)
    body.vertex_rest_rotations.push_back(quaternion_exponential(at_vertices.row(vertex)));
  for (Eigen::Index tet = 0; tet < at_centres.rows(); ++tet)
    body.tet_rest_rotations.push_back(rodrigues(at_centres.row(tet)));
  if (!body.rest_curvature)
    return {};
  // Gamma0 refers to the directors at rest: in the world's axes it is R0 Gamma0 R0^T.
  body.rest_curvature = [axes = std::make_shared<const std::vector<Mat3>>(body.tet_rest_rotations),
                         own = body.rest_curvature](const fem::RestPlace& place, double time) {
    const Mat3& turn = (*axes)[static_cast<std::size_t>(place.tet)];
    return Mat3(turn * own(place, time) * turn.transpose());
  };
  return {};
}

} // namespace wry::pipeline
