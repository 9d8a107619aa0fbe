#include "pipeline/assets/mesh_import.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <span>

#include "pipeline/assets/import_process.h"
#include "pipeline/assets/import_protocol.h"
#include "pipeline/assets/mesh_appearance.h"
#include "sim/geometry/weld.h"
#include "sim/scene/transform.h"

namespace wry::pipeline {

namespace {

// Formats whose readers survived thousands of damaged files, or are our own. Others are refused by name.
constexpr std::array FORMATS = {"ply", "obj", "stl", "off", "gltf", "glb", "fbx", "3ds", "dae"};

} // namespace

Status check_mesh_path(const std::string& path) {
  std::error_code failure;
  const std::filesystem::file_status status = std::filesystem::status(path, failure);
  if (status.type() == std::filesystem::file_type::not_found)
    return make_error(ErrorCode::missing_input, "there is no file {}", path);
  if (failure)
    return make_error(ErrorCode::io, "cannot look at {}: {}", path, failure.message());
  if (status.type() != std::filesystem::file_type::regular)
    return make_error(ErrorCode::bad_input, "{} is not a file", path);
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  const bool is_known = std::any_of(FORMATS.begin(), FORMATS.end(),
                                    [&](const char* format) { return extension == std::string(".") + format; });
  if (!is_known)
    return make_error(ErrorCode::bad_input, "{}: meshes of type '{}' are not read; export it as one of {}", path,
                      extension, fmt::join(FORMATS, ", "));
  return {};
}

namespace {

Error in_file(const std::string& path, const Error& error) {
  if (error.message.find(path) != std::string::npos)
    return error;
  return {error.code, path + ": " + error.message};
}

Result<RawMesh> read_raw(const std::string& path, const MeshImportOptions& options) {
  const Result<std::string> answer =
      run_import_process({options.program, path, options.node, ImportWhat::mesh, options.limits});
  if (!answer)
    return answer.error();
  Result<RawMesh> raw = decode_answer(std::as_bytes(std::span(answer->data(), answer->size())));
  if (!raw)
    return in_file(path, raw.error());
  return raw;
}

Status make_upright_metres(geometry::SurfaceMesh& mesh, const MeshImportOptions& options, const std::string& path) {
  if (!(options.metres_per_unit > 0) || !std::isfinite(options.metres_per_unit))
    return make_error(ErrorCode::bad_input, "units must be positive; one unit is {} m", options.metres_per_unit);
  scene::apply({options.metres_per_unit, scene::up_rotation(options.up, options.scene_up), Vec3::Zero()},
               mesh.vertices);
  if (!mesh.vertices.allFinite())
    return make_error(ErrorCode::bad_input, "{}: coordinates overflow in metres; look at units", path);
  return {};
}

Result<geometry::WeldedMesh> weld_mesh(const geometry::SurfaceMesh& mesh, const MeshImportOptions& options) {
  const geometry::MeshReport before = geometry::inspect_mesh(mesh);
  const double tolerance = options.weld_tolerance.value_or(1e-6 * before.extent().norm());
  return geometry::weld(mesh, tolerance);
}

void note_findings(const geometry::WeldedMesh& welded, std::int64_t vertices, const geometry::OrientReport& oriented,
                   ImportedMesh& result) {
  const geometry::MeshReport& report = result.report;
  std::vector<std::string>& notes = result.notes;
  const Vec3 extent = report.extent();
  notes.insert(notes.begin(),
               fmt::format("{:.4g} x {:.4g} x {:.4g} m, {} vertices, {} triangles, {}", extent.x(), extent.y(),
                           extent.z(), report.vertices, report.triangles,
                           report.is_closed() ? "closed" : fmt::format("{} holes", report.boundary_loops)));
  if (welded.unused_vertices * 5 > vertices)
    notes.push_back(fmt::format("{} of {} vertices belong to no triangle: the file may have been cut short",
                                welded.unused_vertices, vertices));
  if (welded.dropped_triangles > 0)
    notes.push_back(fmt::format("{} triangles without area or there twice were left out", welded.dropped_triangles));
  if (oriented.flipped > 0)
    notes.push_back(fmt::format("{} of {} triangles were turned to face outward", oriented.flipped, report.triangles));
  if (oriented.cavities > 0)
    notes.push_back(fmt::format("{} closed parts bound hollows inside others", oriented.cavities));
}

/// glTF stores colours of vertices as light, the others as they are shown.
ColourCurve colour_curve(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  return extension.starts_with(".gl") || extension.starts_with(".GL") ? ColourCurve::linear : ColourCurve::srgb;
}

} // namespace

Result<ImportedMesh> import_mesh(const std::string& path, const MeshImportOptions& options) {
  if (Status status = check_mesh_path(path); !status)
    return status.error();
  Result<RawMesh> raw = read_raw(path, options);
  if (!raw)
    return std::move(raw).error();
  // Triangles that name a vertex twice are common and harmless; welding drops them. The rest is an error.
  const geometry::MeshReport found = geometry::inspect_mesh(raw->mesh);
  if (found.repeated_corners.count == 0 || found.non_finite_vertices.count > 0)
    if (Status status = geometry::check_valid(raw->mesh, found, path); !status)
      return status.error();
  if (Status status = make_upright_metres(raw->mesh, options, path); !status)
    return status.error();
  Result<geometry::WeldedMesh> welded = weld_mesh(raw->mesh, options);
  if (!welded)
    return in_file(path, welded.error());
  ImportedMesh result;
  result.notes = raw->notes;
  result.mesh = std::move(welded->mesh);
  if (result.mesh.triangles.rows() == 0)
    return make_error(ErrorCode::bad_input, "{}: none of its {} triangles has an area", path,
                      raw->mesh.triangles.rows());
  const Result<geometry::OrientReport> oriented = geometry::orient_outward(result.mesh);
  if (!oriented)
    return in_file(path, oriented.error());
  result.report = geometry::inspect_mesh(result.mesh);
  result.appearance = make_appearance(*raw, result.mesh.triangles, welded->map, colour_curve(path));
  note_findings(*welded, raw->mesh.vertices.rows(), *oriented, result);
  if (options.closedness == Closedness::closed)
    if (Status status = geometry::check_closed(result.report, path); !status)
      return status.error();
  return result;
}

} // namespace wry::pipeline
