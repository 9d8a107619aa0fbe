#include "pipeline/plan/shared_mesh.h"

#include <algorithm>
#include <array>
#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cache/sha256.h"
#include "pipeline/plan/build_id.h"
#include "shots/resolved.h"

namespace wry::pipeline {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::string_view MAGIC = "wrymesh1\n";
constexpr std::size_t HASH_LENGTH = 64;

template <class Matrix> void append_array(std::string& bytes, const Matrix& matrix) {
  bytes.append(reinterpret_cast<const char*>(matrix.data()),
               static_cast<std::size_t>(matrix.size()) * sizeof(typename Matrix::Scalar));
}

/// Reads arrays one after the other; sizes were checked against what is there.
class ArrayReader {
public:
  explicit ArrayReader(std::string_view bytes)
      : m_bytes(bytes) {}
  template <class Matrix> bool read(Matrix& matrix, std::int64_t rows) {
    const auto columns = static_cast<std::int64_t>(matrix.cols());
    if (rows < 0 || (columns > 0 && rows > static_cast<std::int64_t>(m_bytes.size()) / columns))
      return false;
    matrix.resize(rows, columns);
    const std::size_t size = static_cast<std::size_t>(matrix.size()) * sizeof(typename Matrix::Scalar);
    if (size > m_bytes.size())
      return false;
    std::memcpy(static_cast<void*>(matrix.data()), m_bytes.data(), size);
    m_bytes.remove_prefix(size);
    return true;
  }

private:
  std::string_view m_bytes;
};

json report_json(const BodyReport& report) {
  return {{"name", report.name},
          {"source", report.source},
          {"size", {report.size[0], report.size[1], report.size[2]}},
          {"tets", report.tets},
          {"nodes", report.nodes},
          {"surface_triangles", report.surface_triangles},
          {"volume", report.volume},
          {"min_dihedral_deg", report.min_dihedral_deg},
          {"max_dihedral_deg", report.max_dihedral_deg},
          {"min_edge", report.min_edge},
          {"mean_edge", report.mean_edge},
          {"notes", report.notes}};
}

BodyReport report_of(const json& value) {
  BodyReport report;
  report.name = value.at("name");
  report.source = value.at("source");
  for (int i = 0; i < 3; ++i)
    report.size[i] = value.at("size").at(static_cast<std::size_t>(i));
  report.tets = value.at("tets");
  report.nodes = value.at("nodes");
  report.surface_triangles = value.at("surface_triangles");
  report.volume = value.at("volume");
  report.min_dihedral_deg = value.at("min_dihedral_deg");
  report.max_dihedral_deg = value.at("max_dihedral_deg");
  report.min_edge = value.at("min_edge");
  report.mean_edge = value.at("mean_edge");
  report.notes = value.at("notes").get<std::vector<std::string>>();
  return report;
}

/// The lock of one entry, let go of with the object or the process.
class EntryLock {
public:
  explicit EntryLock(const fs::path& path)
      : m_file(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
    if (m_file >= 0)
      flock(m_file, LOCK_EX);
  }
  ~EntryLock() {
    if (m_file >= 0)
      close(m_file);
  }
  EntryLock(const EntryLock&) = delete;
  EntryLock& operator=(const EntryLock&) = delete;

private:
  int m_file;
};

/// Hash of everything that the mesh of a body depends on.
Result<std::string> key_of(const shots::Shot& shot, const shots::Body& body) {
  std::string inputs = fmt::format("{} up {}\n", simulation_build(), static_cast<int>(*shot.shot.up));
  if (const auto* mesh = std::get_if<shots::MeshShape>(&body.shape)) {
    const Result<std::string> hash = sha256_of_file(*mesh->path);
    if (!hash)
      return hash.error();
    inputs += *mesh->path + " " + *hash + "\n";
  }
  const std::string prefix = "body." + *body.name + ".";
  constexpr std::array<std::string_view, 5> NO_SHAPE = {"name", "material", "look", "velocity", "draw"};
  for (const shots::FlatKey& key : shots::flatten(shot)) {
    if (!key.key.starts_with(prefix))
      continue;
    const std::string own = key.key.substr(prefix.size());
    if (std::find(NO_SHAPE.begin(), NO_SHAPE.end(), own) == NO_SHAPE.end())
      inputs += own + "=" + key.value + "\n";
  }
  return sha256_of_bytes(inputs);
}

} // namespace

std::string encode_meshed_body(const MeshedBody& body) {
  const geometry::TetMesh& mesh = *body.mesh;
  json attributes = json::array(), assets = json::array();
  for (const geometry::VertexAttribute& attribute : mesh.attributes)
    attributes.push_back(
        {{"name", attribute.name}, {"components", attribute.components}, {"values", attribute.values.size()}});
  for (const Asset& asset : body.assets)
    assets.push_back({{"path", asset.path}, {"sha256", asset.sha256}});
  const std::string head = json{{"vertices", mesh.vertices.rows()},
                                {"tets", mesh.tets.rows()},
                                {"body_coordinates", mesh.body_coordinates.rows()},
                                {"attributes", attributes},
                                {"assets", assets},
                                {"report", report_json(body.report)}}
                               .dump();
  std::string bytes(MAGIC);
  bytes += fmt::format("{:016}", head.size()) + head;
  append_array(bytes, mesh.vertices);
  append_array(bytes, mesh.tets);
  append_array(bytes, mesh.body_coordinates);
  for (const geometry::VertexAttribute& attribute : mesh.attributes)
    append_array(bytes, Eigen::Map<const Eigen::VectorXd>(attribute.values.data(),
                                                          static_cast<Eigen::Index>(attribute.values.size())));
  return bytes + sha256_of_bytes(bytes);
}

Result<MeshedBody> decode_meshed_body(const std::string& bytes, const std::string& name) {
  const Error damaged = make_error(ErrorCode::io, "{} is damaged", name);
  const std::size_t begin = MAGIC.size() + 16;
  if (bytes.size() < begin + HASH_LENGTH || !bytes.starts_with(MAGIC))
    return damaged;
  const std::string_view content(bytes.data(), bytes.size() - HASH_LENGTH);
  if (sha256_of_bytes(content) != std::string_view(bytes).substr(content.size()))
    return damaged;
  try {
    const std::size_t length = std::stoull(bytes.substr(MAGIC.size(), 16));
    if (length > content.size() - begin)
      return damaged;
    const json head = json::parse(content.substr(begin, length));
    ArrayReader reader(content.substr(begin + length));
    geometry::TetMesh mesh;
    bool whole = reader.read(mesh.vertices, head.at("vertices")) && reader.read(mesh.tets, head.at("tets")) &&
                 reader.read(mesh.body_coordinates, head.at("body_coordinates"));
    for (const json& entry : head.at("attributes")) {
      geometry::VertexAttribute attribute;
      attribute.name = entry.at("name");
      attribute.components = entry.at("components");
      Eigen::VectorXd values;
      whole = whole && reader.read(values, entry.at("values"));
      attribute.values.assign(values.data(), values.data() + values.size());
      mesh.attributes.push_back(std::move(attribute));
    }
    if (!whole)
      return damaged;
    MeshedBody body;
    body.mesh = std::make_shared<const geometry::TetMesh>(std::move(mesh));
    body.report = report_of(head.at("report"));
    for (const json& asset : head.at("assets"))
      body.assets.push_back({asset.at("path"), asset.at("sha256")});
    return body;
  } catch (const std::exception&) {
    return damaged;
  }
}

Result<MeshedBody> mesh_body_shared(const shots::Shot& shot, const shots::Body& body, Filling filling,
                                    const fs::path& folder) {
  const shots::Axis up = *shot.shot.up;
  if (filling == Filling::nothing || folder.empty() || !prepare_folder(folder))
    return mesh_body(body, up, filling);
  const Result<std::string> key = key_of(shot, body);
  if (!key)
    return mesh_body(body, up); // whose message names the line
  const fs::path path = folder / (*key + ".mesh");
  const EntryLock lock(folder / (*key + ".lock"));
  if (const Result<std::string> bytes = read_whole_file(path); bytes) {
    if (Result<MeshedBody> meshed = decode_meshed_body(*bytes, path.string()); meshed) {
      meshed->report.name = *body.name;
      return meshed;
    }
  }
  Result<MeshedBody> meshed = mesh_body(body, up);
  if (meshed)
    static_cast<void>(write_file_atomically(path, encode_meshed_body(*meshed)));
  return meshed;
}

} // namespace wry::pipeline
