#include <iterator>

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/export/exporter.h"
#include "pipeline/export/obj_text.h"

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

Status export_obj(const ExportJob& job) {
  return for_each_frame(job, [&](const Frame& frame) -> Status {
    for (std::size_t b = 0; b < frame.bodies.size(); ++b) {
      const SceneBody& body = job.scene.bodies[b];
      const Result<ExportPoints> points = export_points(body, frame.bodies[b]);
      if (!points)
        return points.error();
      if (!points->is_mesh)
        return make_error(ErrorCode::bad_input,
                          "body {} has no surface, which is all that obj can hold; --to ply, usda "
                          "or vdb take points",
                          body.name);
      if (Status status = write_file_atomically(job.folder / sequence_name(body.name, frame.number, "obj"),
                                                obj_text(body.name, points->positions, body.triangles));
          !status)
        return status;
    }
    return {};
  });
}

} // namespace wry::pipeline
