#include "tests/pipeline/import_files_support.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <unistd.h>

namespace wry::pipeline {

namespace {

template <class T> void put(std::string& bytes, T value, bool swap = false) {
  std::string raw(reinterpret_cast<const char*>(&value), sizeof(T));
  if (swap)
    std::reverse(raw.begin(), raw.end());
  bytes += raw;
}

std::string obj_bytes(const geometry::SurfaceMesh& mesh) {
  std::string text = "# a mesh\no thing\n";
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    text += fmt::format("v {:.7f} {:.7f} {:.7f}\n", mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t)
    text += fmt::format("f {} {} {}\n", mesh.triangles(t, 0) + 1, mesh.triangles(t, 1) + 1, mesh.triangles(t, 2) + 1);
  return text;
}

std::string off_bytes(const geometry::SurfaceMesh& mesh) {
  std::string text = fmt::format("OFF\n{} {} 0\n", mesh.vertices.rows(), mesh.triangles.rows());
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    text += fmt::format("{:.7f} {:.7f} {:.7f}\n", mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t)
    text += fmt::format("3 {} {} {}\n", mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2));
  return text;
}

std::string stl_bytes(const geometry::SurfaceMesh& mesh) {
  std::string bytes(80, ' ');
  put(bytes, static_cast<std::uint32_t>(mesh.triangles.rows()));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int i = 0; i < 3; ++i)
      put(bytes, 0.0f);
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i)
        put(bytes, static_cast<float>(mesh.vertices(mesh.triangles(t, k), i)));
    put(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string ascii_stl_bytes(const geometry::SurfaceMesh& mesh) {
  std::string text = "solid thing\n";
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    text += "facet normal 0 0 0\n outer loop\n";
    for (int k = 0; k < 3; ++k) {
      const Eigen::RowVector3d p = mesh.vertices.row(mesh.triangles(t, k));
      text += fmt::format("  vertex {:.7f} {:.7f} {:.7f}\n", p[0], p[1], p[2]);
    }
    text += " endloop\nendfacet\n";
  }
  return text + "endsolid thing\n";
}

std::string ply_bytes(const geometry::SurfaceMesh& mesh, const std::string& kind) {
  const bool is_ascii = kind == "ply-ascii";
  const bool swap = kind == "ply-big";
  std::string bytes =
      fmt::format("ply\nformat {} 1.0\ncomment made by a test\nelement vertex {}\nproperty float x\nproperty "
                  "float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar "
                  "blue\nproperty double stiffness\nelement face {}\nproperty list uchar int "
                  "vertex_indices\nend_header\n",
                  is_ascii ? "ascii"
                  : swap   ? "binary_big_endian"
                           : "binary_little_endian",
                  mesh.vertices.rows(), mesh.triangles.rows());
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    if (is_ascii) {
      bytes += fmt::format("{:.7f} {:.7f} {:.7f} 255 51 0 {}\n", mesh.vertices(v, 0), mesh.vertices(v, 1),
                           mesh.vertices(v, 2), v);
      continue;
    }
    for (int i = 0; i < 3; ++i)
      put(bytes, static_cast<float>(mesh.vertices(v, i)), swap);
    for (const int colour : {255, 51, 0})
      put(bytes, static_cast<std::uint8_t>(colour));
    put(bytes, static_cast<double>(v), swap);
  }
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (is_ascii) {
      bytes += fmt::format("3 {} {} {}\n", mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2));
      continue;
    }
    put(bytes, std::uint8_t{3});
    for (int k = 0; k < 3; ++k)
      put(bytes, mesh.triangles(t, k), swap);
  }
  return bytes;
}

// Two nodes show the mesh: "left" as it is, "right" moved by 10 along x and mirrored in x.
std::string glb_bytes(const geometry::SurfaceMesh& mesh) {
  std::string data;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      put(data, static_cast<std::uint32_t>(mesh.triangles(t, k)));
  const std::size_t index_bytes = data.size();
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    for (int i = 0; i < 3; ++i)
      put(data, static_cast<float>(mesh.vertices(v, i)));
  const Eigen::RowVector3d lower = mesh.vertices.colwise().minCoeff();
  const Eigen::RowVector3d upper = mesh.vertices.colwise().maxCoeff();
  std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1]}}],"nodes":[{{"name":"left","mesh":0}},{{"name":"right","mesh":0,"translation":[10,0,0],"scale":[-1,1,1]}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":1}},"indices":0}}]}}],"accessors":[{{"bufferView":0,"componentType":5125,"count":{},"type":"SCALAR"}},{{"bufferView":1,"componentType":5126,"count":{},"type":"VEC3","min":[{},{},{}],"max":[{},{},{}]}}],"bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}}],"buffers":[{{"byteLength":{}}}]}})",
      mesh.triangles.size(), mesh.vertices.rows(), lower[0], lower[1], lower[2], upper[0], upper[1], upper[2],
      index_bytes, index_bytes, data.size() - index_bytes, data.size());
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string bytes = "glTF";
  put(bytes, std::uint32_t{2});
  put(bytes, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + data.size()));
  put(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  put(bytes, static_cast<std::uint32_t>(data.size()));
  return bytes + std::string("BIN\0", 4) + data;
}

} // namespace

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "wry_import_XXXXXX").string();
  m_path = mkdtemp(pattern.data());
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(m_path, ignored);
}

std::string TemporaryFolder::write(const std::string& name, const std::string& bytes) const {
  const std::string path = m_path + "/" + name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

std::string mesh_file_bytes(const geometry::SurfaceMesh& mesh, const std::string& kind) {
  if (kind == "obj")
    return obj_bytes(mesh);
  if (kind == "off")
    return off_bytes(mesh);
  if (kind == "stl")
    return stl_bytes(mesh);
  if (kind == "stl-ascii")
    return ascii_stl_bytes(mesh);
  if (kind == "glb")
    return glb_bytes(mesh);
  return ply_bytes(mesh, kind);
}

std::string extension_of(const std::string& kind) {
  return fmt::format(".{}", kind.substr(0, kind.find('-')));
}

} // namespace wry::pipeline
