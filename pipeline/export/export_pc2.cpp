#include <cstring>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/export/exporter.h"
#include "pipeline/export/obj_text.h"

namespace wry::pipeline {

namespace {

template <class T> void append(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

/// "POINTCACHE2\0", version 1, points, first frame, frames per sample, samples; then floats.
std::string pc2_header(Eigen::Index points, const ExportJob& job) {
  std::string bytes("POINTCACHE2\0", 12);
  append(bytes, std::int32_t{1});
  append(bytes, static_cast<std::int32_t>(points));
  append(bytes, static_cast<float>(job.frames.front()));
  const bool stepped = job.frames.size() > 1;
  append(bytes, stepped ? static_cast<float>(job.frames[1] - job.frames[0]) : 1.f);
  append(bytes, static_cast<std::int32_t>(job.frames.size()));
  return bytes;
}

/// A sample per step is all that the format has.
Status check_even(const ExportJob& job) {
  for (std::size_t i = 2; i < job.frames.size(); ++i) {
    if (job.frames[i] - job.frames[i - 1] != job.frames[1] - job.frames[0])
      return make_error(ErrorCode::bad_input,
                        "pc2 holds evenly spaced frames only, but {} follows {}; give --frames "
                        "such as 1-48x2",
                        job.frames[i], job.frames[i - 1]);
  }
  return {};
}

Status write_body(const ExportJob& job, std::size_t index) {
  const SceneBody& body = job.scene.bodies[index];
  Eigen::Index count = -1;
  std::string bytes;
  const Status gathered = for_each_frame(job, [&](const Frame& frame) -> Status {
    const Result<ExportPoints> points = export_points(body, frame.bodies[index]);
    if (!points)
      return points.error();
    if (!points->is_mesh)
      return make_error(ErrorCode::bad_input,
                        "body {} is no mesh; pc2 holds meshes of constant topology only; --to ply "
                        "or usda take points",
                        body.name);
    if (count < 0)
      bytes = pc2_header(count = points->positions.rows(), job);
    if (count != points->positions.rows())
      return make_error(ErrorCode::bad_input, "body {}: {} points in frame {}, {} before; pc2 holds constant topology",
                        body.name, points->positions.rows(), frame.number, count);
    for (Eigen::Index i = 0; i < points->positions.size(); ++i)
      append(bytes, static_cast<float>(points->positions.data()[i]));
    return {};
  });
  if (!gathered)
    return gathered;
  const std::string name = export_name(body.name);
  if (Status status =
          write_file_atomically(job.folder / (name + ".obj"), obj_text(body.name, body.rest_positions, body.triangles));
      !status)
    return status;
  return write_file_atomically(job.folder / (name + ".pc2"), bytes);
}

} // namespace

Status export_pc2(const ExportJob& job) {
  if (Status status = check_even(job); !status)
    return status;
  for (std::size_t index = 0; index < job.scene.bodies.size(); ++index) {
    if (Status status = write_body(job, index); !status)
      return status;
  }
  return {};
}

} // namespace wry::pipeline
