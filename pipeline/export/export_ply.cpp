#include <cstring>

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/export/exporter.h"

namespace wry::pipeline {

namespace {

template <class T> void append(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T)); // x86 is little endian, as the header says
  bytes.append(raw, sizeof(T));
}

std::string ply_header(const ExportPoints& points, const SceneBody& body, const Frame& frame, double fps) {
  std::string head = fmt::format("ply\nformat binary_little_endian 1.0\ncomment wry frame {} time {} fps {} metres\n"
                                 "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n",
                                 frame.number, frame.time, fps, points.positions.rows());
  head += "property int id\n";
  if (points.velocity.rows() > 0)
    head += "property float vx\nproperty float vy\nproperty float vz\n";
  if (points.orientation.rows() > 0)
    head += "property float qw\nproperty float qx\nproperty float qy\nproperty float qz\n";
  if (points.size.rows() > 0)
    head += "property float sx\nproperty float sy\nproperty float sz\n";
  for (const Channel* channel : points.other)
    head += fmt::format("property float {}\n", export_name(channel->name));
  if (points.is_mesh)
    head += fmt::format("element face {}\nproperty list uchar int vertex_indices\n", body.triangles.rows());
  return head + "end_header\n";
}

std::string ply_bytes(const ExportPoints& points, const SceneBody& body, const Frame& frame, double fps) {
  std::string bytes = ply_header(points, body, frame, fps);
  const auto append_row = [&](const auto& rows, Eigen::Index row) {
    for (Eigen::Index c = 0; c < rows.cols(); ++c)
      append(bytes, static_cast<float>(rows(row, c)));
  };
  for (Eigen::Index i = 0; i < points.positions.rows(); ++i) {
    append_row(points.positions, i);
    append(bytes, static_cast<std::int32_t>(i));
    if (points.velocity.rows() > 0)
      append_row(points.velocity, i);
    if (points.orientation.rows() > 0)
      append_row(points.orientation, i);
    if (points.size.rows() > 0)
      append_row(points.size, i);
    for (const Channel* channel : points.other)
      append(bytes, static_cast<float>(channel->values[static_cast<std::size_t>(i)]));
  }
  for (Eigen::Index i = 0; points.is_mesh && i < body.triangles.rows(); ++i) {
    append(bytes, std::uint8_t{3});
    for (Eigen::Index c = 0; c < 3; ++c)
      append(bytes, body.triangles(i, c));
  }
  return bytes;
}

} // namespace

Status export_ply(const ExportJob& job) {
  return for_each_frame(job, [&](const Frame& frame) -> Status {
    for (std::size_t b = 0; b < frame.bodies.size(); ++b) {
      const SceneBody& body = job.scene.bodies[b];
      const Result<ExportPoints> points = export_points(body, frame.bodies[b]);
      if (!points)
        return points.error();
      if (Status status = write_file_atomically(job.folder / sequence_name(body.name, frame.number, "ply"),
                                                ply_bytes(*points, body, frame, job.fps));
          !status)
        return status;
    }
    return {};
  });
}

} // namespace wry::pipeline
