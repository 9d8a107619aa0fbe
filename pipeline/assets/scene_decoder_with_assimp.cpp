#include "pipeline/assets/node_motion_with_assimp.h"
#include "pipeline/assets/scene_decoder.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "pipeline/assets/materials.h"

namespace wry::pipeline {

namespace {

constexpr std::size_t MAX_NODES = 1'000'000;
constexpr std::size_t MAX_ROWS = std::numeric_limits<std::int32_t>::max() / 3;

class MemoryStream : public Assimp::IOStream {
public:
  explicit MemoryStream(const std::string& bytes)
      : m_bytes(bytes) {}

  std::size_t Read(void* buffer, std::size_t size, std::size_t count) override {
    if (size == 0)
      return 0;
    const std::size_t whole = std::min(count, (m_bytes.size() - m_at) / size);
    std::memcpy(buffer, m_bytes.data() + m_at, whole * size);
    m_at += whole * size;
    return whole;
  }
  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    const std::size_t base = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? m_at : m_bytes.size();
    const std::size_t target = origin == aiOrigin_END ? base - offset : base + offset;
    if (target > m_bytes.size())
      return aiReturn_FAILURE;
    m_at = target;
    return aiReturn_SUCCESS;
  }
  std::size_t Tell() const override { return m_at; }
  std::size_t FileSize() const override { return m_bytes.size(); }
  void Flush() override {}

private:
  const std::string& m_bytes;
  std::size_t m_at = 0;
};

// Gives out what has been read before the process was locked in.
class MemoryFiles : public Assimp::IOSystem {
public:
  explicit MemoryFiles(const std::map<std::string, std::string>& files)
      : m_files(files) {}

  bool Exists(const char* path) const override { return m_files.count(name_of(path)) != 0; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* path, const char* mode) override {
    const auto found = m_files.find(name_of(path));
    const bool is_writing = std::strpbrk(mode, "wa+") != nullptr;
    return found == m_files.end() || is_writing ? nullptr : new MemoryStream(found->second);
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

private:
  static std::string name_of(std::string path) {
    while (path.starts_with("./"))
      path.erase(0, 2);
    return path;
  }

  const std::map<std::string, std::string>& m_files;
};

// Only the readers of this extension stay: the library otherwise guesses by content, also formats that it reads badly.
void keep_readers_of(Assimp::Importer& importer, const std::string& extension) {
  std::vector<Assimp::BaseImporter*> others;
  for (std::size_t i = 0; i < importer.GetImporterCount(); ++i) {
    const std::string extensions = std::string(" ") + importer.GetImporterInfo(i)->mFileExtensions + " ";
    if (extensions.find(" " + extension + " ") == std::string::npos)
      others.push_back(importer.GetImporter(i));
  }
  for (Assimp::BaseImporter* other : others) {
    importer.UnregisterLoader(other);
    // The importer no longer owns it; the process ends soon, so it is left.
  }
}

// A mesh under a node, with the transform from the root.
struct Instance {
  const aiMesh* mesh;
  aiMatrix4x4 transform;
};

struct Visit {
  const aiNode* node;
  aiMatrix4x4 parent;
  bool chosen;
};

Result<std::vector<Instance>> collect_instances(const aiScene& scene, const std::string& wanted) {
  std::vector<Instance> instances;
  std::vector<std::string> names;
  std::vector<Visit> open = {{scene.mRootNode, aiMatrix4x4(), wanted.empty()}};
  bool found = wanted.empty();
  std::size_t visited = 0;
  while (!open.empty()) {
    const Visit visit = open.back();
    open.pop_back();
    if (++visited > MAX_NODES)
      return make_error(ErrorCode::bad_input, "more than {} nodes", MAX_NODES);
    const aiNode& node = *visit.node;
    const aiMatrix4x4 transform = visit.parent * node.mTransformation;
    const bool chosen = visit.chosen || wanted == node.mName.C_Str();
    found = found || chosen;
    if (names.size() < 12 && node.mName.length > 0)
      names.emplace_back(node.mName.C_Str());
    for (unsigned i = 0; chosen && i < node.mNumMeshes; ++i)
      if (node.mMeshes[i] < scene.mNumMeshes)
        instances.push_back({scene.mMeshes[node.mMeshes[i]], transform});
    for (unsigned i = node.mNumChildren; i > 0; --i)
      open.push_back({node.mChildren[i - 1], transform, chosen});
  }
  if (!found)
    return make_error(ErrorCode::bad_input, "there is no node '{}'; there are {}{}", wanted, fmt::join(names, ", "),
                      visited > names.size() ? ", ..." : "");
  return instances;
}

class Gatherer {
public:
  explicit Gatherer(const std::vector<Instance>& instances)
      : m_instances(instances) {
    for (const Instance& instance : instances) {
      m_has_colour = m_has_colour || instance.mesh->HasVertexColors(0);
      m_has_uv = m_has_uv || instance.mesh->HasTextureCoords(0);
    }
  }

  Result<RawMesh> gather() {
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    for (const Instance& instance : m_instances) {
      vertices += instance.mesh->mNumVertices;
      for (unsigned f = 0; f < instance.mesh->mNumFaces; ++f)
        triangles += instance.mesh->mFaces[f].mNumIndices == 3;
    }
    if (triangles == 0)
      return make_error(ErrorCode::bad_input, "it holds no triangles or polygons");
    if (vertices > MAX_ROWS || triangles > MAX_ROWS)
      return make_error(ErrorCode::bad_input, "{} vertices and {} triangles are too many", vertices, triangles);
    m_raw.mesh.vertices.resize(static_cast<Eigen::Index>(vertices), 3);
    m_raw.mesh.triangles.resize(static_cast<Eigen::Index>(triangles), 3);
    if (m_has_colour)
      m_colour = {"colour", 3, std::vector<double>(vertices * 3, 0.0)};
    if (m_has_uv)
      m_uv = {"uv", 2, std::vector<double>(vertices * 2, 0.0)};
    for (const Instance& instance : m_instances)
      if (Status status = add(instance); !status)
        return status.error();
    if (m_has_colour)
      m_raw.mesh.attributes.push_back(std::move(m_colour));
    if (m_has_uv)
      m_raw.mesh.attributes.push_back(std::move(m_uv));
    if (m_skipped > 0)
      m_raw.notes.push_back(fmt::format("{} points and lines were left out", m_skipped));
    if (m_skinned > 0)
      m_raw.notes.push_back(fmt::format("{} meshes are bound to bones; they come in their bind pose", m_skinned));
    return std::move(m_raw);
  }

private:
  Status add(const Instance& instance) {
    const aiMesh& mesh = *instance.mesh;
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D point = instance.transform * mesh.mVertices[v];
      const auto row = static_cast<Eigen::Index>(m_vertices + v);
      m_raw.mesh.vertices.row(row) << point.x, point.y, point.z;
      if (mesh.HasVertexColors(0)) {
        const aiColor4D& colour = mesh.mColors[0][v];
        const double values[] = {colour.r, colour.g, colour.b};
        std::copy_n(values, 3, m_colour.values.begin() + row * 3);
      }
      if (mesh.HasTextureCoords(0)) {
        const aiVector3D& uv = mesh.mTextureCoords[0][v];
        const double values[] = {uv.x, uv.y};
        std::copy_n(values, 2, m_uv.values.begin() + row * 2);
      }
    }
    // A mirroring transform turns triangles inside out.
    const bool is_mirrored = instance.transform.Determinant() < 0;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) {
        ++m_skipped;
        continue;
      }
      for (unsigned k = 0; k < 3; ++k) {
        const unsigned index = face.mIndices[is_mirrored ? 2 - k : k];
        if (index >= mesh.mNumVertices)
          return make_error(ErrorCode::bad_input, "a face names vertex {}, but its mesh has only {}", index,
                            mesh.mNumVertices);
        m_raw.mesh.triangles(m_triangle, k) = static_cast<std::int32_t>(m_vertices + index);
      }
      m_raw.material_of_triangle.push_back(static_cast<std::int32_t>(mesh.mMaterialIndex));
      ++m_triangle;
    }
    m_vertices += mesh.mNumVertices;
    m_skinned += mesh.HasBones();
    return {};
  }

  const std::vector<Instance>& m_instances;
  RawMesh m_raw;
  geometry::VertexAttribute m_colour;
  geometry::VertexAttribute m_uv;
  bool m_has_colour = false;
  bool m_has_uv = false;
  std::size_t m_vertices = 0;
  Eigen::Index m_triangle = 0;
  std::int64_t m_skipped = 0;
  std::int64_t m_skinned = 0;
};

// FBX files say their unit and up axis, and lie about them often enough: for the user to compare.
void note_units(const aiScene& scene, std::vector<std::string>& notes) {
  if (scene.mMetaData == nullptr)
    return;
  double centimetres = 0;
  float centimetres_single = 0;
  if (scene.mMetaData->Get("UnitScaleFactor", centimetres_single))
    centimetres = centimetres_single;
  else
    scene.mMetaData->Get("UnitScaleFactor", centimetres);
  if (centimetres > 0)
    notes.push_back(
        fmt::format("the file says that its unit is {:g} cm; what counts is the body's units", centimetres));
  std::int32_t up = -1;
  if (scene.mMetaData->Get("UpAxis", up) && up >= 0 && up < 3)
    notes.push_back(fmt::format("the file says that {} is up; what counts is the body's up", "xyz"[up]));
}

} // namespace

Result<RawMesh> decode_scene(const MeshFile& file) {
  try {
    // Never destroyed: the process ends after this, and freeing what a damaged file left behind can only go wrong.
    auto* importer = new Assimp::Importer;
    importer->SetIOHandler(new MemoryFiles(file.files));
    keep_readers_of(*importer, file.extension);
    if (importer->GetImporterCount() == 0)
      return make_error(ErrorCode::unavailable, "this assimp does not read .{} files", file.extension);
    const aiScene* scene = importer->ReadFile(file.name, aiProcess_Triangulate);
    if (scene == nullptr)
      return make_error(ErrorCode::bad_input, "{}", importer->GetErrorString());
    if (scene->mRootNode == nullptr)
      return make_error(ErrorCode::bad_input, "it holds no nodes");
    if (file.what == ImportWhat::motion) {
      Result<RawMotion> motion = read_node_motion(*scene, file.node, file.extension);
      if (!motion)
        return motion.error();
      RawMesh raw;
      raw.motion = std::move(*motion);
      return raw;
    }
    const Result<std::vector<Instance>> instances = collect_instances(*scene, file.node);
    if (!instances)
      return instances.error();
    Result<RawMesh> raw = Gatherer(*instances).gather();
    if (raw) {
      note_units(*scene, raw->notes);
      gather_materials(*scene, file, *raw);
      const auto count = static_cast<std::int32_t>(raw->materials.size());
      if (std::any_of(raw->material_of_triangle.begin(), raw->material_of_triangle.end(),
                      [count](std::int32_t material) { return material < 0 || material >= count; }))
        raw->material_of_triangle.clear();
    }
    return raw;
  } catch (const std::exception& error) {
    return make_error(ErrorCode::bad_input, "{}", error.what());
  }
}

} // namespace wry::pipeline
