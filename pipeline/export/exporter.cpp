#include "pipeline/export/exporter.h"

#include <array>
#include <cctype>

#include <fmt/format.h>

namespace wry::pipeline {

namespace {

constexpr std::array EXPORTERS = {
    Exporter{"ply", "a file per body and frame: points or mesh with ids, velocity, orientation and scalars",
             export_ply},
    Exporter{"obj", "a mesh file per body and frame; grains of an artist mesh all in one", export_obj},
    Exporter{"vdb", "a file per frame: level sets of meshes, density and velocity of particles", export_vdb},
    Exporter{"usda", "one USD file: time-sampled meshes, point instancers with orientations, moving colliders",
             export_usda},
    Exporter{"pc2", "a point cache per mesh, beside its rest shape as obj", export_pc2},
    Exporter{"xdmf", "one file for ParaView that points into the frame cache", export_xdmf},
};

const Channel* points_channel(const FrameBody& frame, const std::string& name, int components, Eigen::Index rows) {
  const Channel* channel = find_channel(frame, name);
  const bool fits = channel != nullptr && channel->components == components &&
                    static_cast<Eigen::Index>(channel->values.size()) == rows * components;
  return fits ? channel : nullptr;
}

template <class Rows> Rows rows_of(const Channel& channel) {
  return Eigen::Map<const Rows>(channel.values.data(),
                                static_cast<Eigen::Index>(channel.values.size()) / Rows::ColsAtCompileTime,
                                Rows::ColsAtCompileTime);
}

} // namespace

std::span<const Exporter> exporters() {
  return EXPORTERS;
}

Status for_each_frame(const ExportJob& job, const std::function<Status(const Frame&)>& use) {
  return for_each_cached_frame(job, [&](const Frame& frame) { return use(job.as_shown(frame)); });
}

Status for_each_cached_frame(const ExportJob& job, const std::function<Status(const Frame&)>& use) {
  for (const int number : job.frames) {
    const Result<Frame> frame = job.cache.read_frame(number);
    if (!frame)
      return frame.error();
    if (Status status = use(*frame); !status)
      return status;
  }
  return {};
}

bool is_mesh(const SceneBody& body) {
  return body.kind == BodyKind::surface && body.triangles.rows() > 0;
}

Result<ExportPoints> export_points(const SceneBody& body, const FrameBody& frame) {
  ExportPoints points;
  points.is_mesh = is_mesh(body);
  const Channel* position = find_channel(frame, "position");
  if (position == nullptr && !body.simulated) {
    const Mat3 turn = frame.transform.topLeftCorner<3, 3>();
    const Vec3 shift = frame.transform.topRightCorner<3, 1>();
    points.positions = body.rest_positions * turn.transpose();
    points.positions.rowwise() += shift.transpose();
    return points;
  }
  if (position == nullptr || position->components != 3)
    return make_error(ErrorCode::bad_input, "body {} has no positions in this frame", body.name);
  points.positions = rows_of<Points>(*position);
  const Eigen::Index count = points.positions.rows();
  if (const Channel* velocity = points_channel(frame, "velocity", 3, count))
    points.velocity = rows_of<Points>(*velocity);
  for (const char* name : {"orientation", "microrotation"}) {
    const Channel* turn = points_channel(frame, name, 4, count);
    if (turn != nullptr && points.orientation.rows() == 0)
      points.orientation = rows_of<Quaternions>(*turn);
  }
  if (const Channel* size = points_channel(frame, "size", 3, count))
    points.size = rows_of<Points>(*size);
  for (const Channel& channel : frame.channels) {
    if (points_channel(frame, channel.name, 1, count) != nullptr)
      points.other.push_back(&channel);
  }
  return points;
}

std::string export_name(std::string_view name) {
  std::string safe;
  for (const char c : name)
    safe += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  if (safe.empty() || std::isdigit(static_cast<unsigned char>(safe.front())) != 0)
    safe.insert(safe.begin(), '_');
  return safe;
}

std::string sequence_name(std::string_view body, int frame, std::string_view extension) {
  return fmt::format("{}.{:04}.{}", export_name(body), frame, extension);
}

} // namespace wry::pipeline
