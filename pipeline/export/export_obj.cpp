#include <iterator>

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/export/exporter.h"
#include "pipeline/export/obj_text.h"
#include "sim/base/rotation.h"

namespace wry::pipeline {

std::string obj_text(const std::string& name, const Points& positions, const Triangles& triangles) {
  std::string text = fmt::format("# wry, metres\no {}\n", export_name(name));
  for (Eigen::Index i = 0; i < positions.rows(); ++i)
    fmt::format_to(std::back_inserter(text), "v {:.9g} {:.9g} {:.9g}\n", positions(i, 0), positions(i, 1),
                   positions(i, 2));
  for (Eigen::Index i = 0; i < triangles.rows(); ++i)
    fmt::format_to(std::back_inserter(text), "f {} {} {}\n", triangles(i, 0) + 1, triangles(i, 1) + 1,
                   triangles(i, 2) + 1);
  return text;
}

namespace {

/// The artist's mesh once for every grain, where it is.
geometry::SurfaceMesh mesh_of_grains(const SceneBody& body, const ExportPoints& grains) {
  const Eigen::Index vertices = body.rest_positions.rows(), triangles = body.triangles.rows();
  geometry::SurfaceMesh all;
  all.vertices.resize(grains.positions.rows() * vertices, 3);
  all.triangles.resize(grains.positions.rows() * triangles, 3);
  for (Eigen::Index i = 0; i < grains.positions.rows(); ++i) {
    const Vec3 size = grains.size.rows() > 0 ? Vec3(grains.size.row(i)) : body.grain.size;
    const Vec4 turn = grains.orientation.rows() > 0 ? Vec4(grains.orientation.row(i)) : identity_quaternion();
    const Mat3 placed = rotation_matrix(turn) * size.asDiagonal();
    all.vertices.middleRows(i * vertices, vertices) = body.rest_positions * placed.transpose();
    all.vertices.middleRows(i * vertices, vertices).rowwise() += grains.positions.row(i);
    all.triangles.middleRows(i * triangles, triangles) =
        body.triangles.array() + static_cast<std::int32_t>(i * vertices);
  }
  return all;
}

/// A body on a frame as triangles. Errors: bad_input for points that are drawn as a shape of ours.
Result<geometry::SurfaceMesh> triangles_of(const SceneBody& body, const FrameBody& on_frame) {
  Result<ExportPoints> points = export_points(body, on_frame);
  if (!points)
    return points.error();
  if (points->is_mesh)
    return geometry::SurfaceMesh{std::move(points->positions), body.triangles, {}};
  if (body.kind == BodyKind::particles && body.grain.shape == GrainShape::mesh)
    return mesh_of_grains(body, *points);
  return make_error(ErrorCode::bad_input,
                    "body {} has no surface, which is all that obj can hold; --to ply, usda or vdb take points",
                    body.name);
}

/// Particles that grains are drawn in place of.
bool is_hidden(const SceneBody& body) {
  return body.simulated && body.kind == BodyKind::surface && body.triangles.rows() == 0;
}

} // namespace

Status export_obj(const ExportJob& job) {
  return for_each_frame(job, [&](const Frame& frame) -> Status {
    for (std::size_t b = 0; b < frame.bodies.size(); ++b) {
      const SceneBody& body = job.scene.bodies[b];
      if (is_hidden(body))
        continue;
      const Result<geometry::SurfaceMesh> mesh = triangles_of(body, frame.bodies[b]);
      if (!mesh)
        return mesh.error();
      if (Status status = write_file_atomically(job.folder / sequence_name(body.name, frame.number, "obj"),
                                                obj_text(body.name, mesh->vertices, mesh->triangles));
          !status)
        return status;
    }
    return {};
  });
}

} // namespace wry::pipeline
