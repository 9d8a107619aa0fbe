#include "pipeline/assets/import_protocol.h"

#include <cmath>
#include <cstring>
#include <limits>

namespace wry::pipeline {

namespace {

constexpr char MESH_MAGIC[] = "WRYMESH2";
constexpr char FAIL_MAGIC[] = "WRYFAIL1";
constexpr std::size_t MAGIC_SIZE = 8;
constexpr std::uint64_t MAX_ATTRIBUTES = 256;
constexpr std::uint64_t MAX_NOTES = 256;
constexpr std::uint64_t MAX_TEXT = 4096;
constexpr std::uint32_t MAX_COMPONENTS = 16;
constexpr std::uint64_t MAX_MOTION_SAMPLES = 100'000;
constexpr std::uint64_t MAX_MATERIALS = 100'000;
constexpr std::int32_t MAX_TEXTURES = 256;
constexpr std::int32_t MAX_SIDE = 8192;

template <class T> void put(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

void put_text(std::string& bytes, const std::string& text) {
  const auto length = static_cast<std::uint32_t>(std::min<std::size_t>(text.size(), MAX_TEXT));
  put(bytes, length);
  bytes.append(text, 0, length);
}

template <class T> void put_array(std::string& bytes, const T* values, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

// Reads from front to back; after the first failure everything reads as nothing.
class Reader {
public:
  explicit Reader(std::span<const std::byte> bytes)
      : m_bytes(bytes) {}

  bool ok() const { return m_ok; }
  bool at_end() const { return m_ok && m_bytes.empty(); }
  std::size_t left() const { return m_bytes.size(); }

  template <class T> T get() {
    T value{};
    get_array(&value, 1);
    return value;
  }

  template <class T> void get_array(T* values, std::size_t count) {
    if (!m_ok || count > m_bytes.size() / sizeof(T)) {
      m_ok = false;
      return;
    }
    if (count > 0)
      std::memcpy(values, m_bytes.data(), count * sizeof(T));
    m_bytes = m_bytes.subspan(count * sizeof(T));
  }

  std::string get_text() {
    const auto length = get<std::uint32_t>();
    if (!m_ok || length > MAX_TEXT || length > m_bytes.size()) {
      m_ok = false;
      return {};
    }
    std::string text(length, '\0');
    get_array(text.data(), length);
    for (char& c : text)
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
        c = ' ';
    return text;
  }

private:
  std::span<const std::byte> m_bytes;
  bool m_ok = true;
};

Error nonsense(const char* what) {
  return make_error(ErrorCode::io, "the import process gave an answer that makes no sense ({})", what);
}

Error get_failure(Reader& reader) {
  const auto code = reader.get<std::int32_t>();
  const std::string message = reader.get_text();
  if (!reader.at_end() || message.empty())
    return nonsense("a broken error message");
  switch (static_cast<ErrorCode>(code)) {
  case ErrorCode::bad_input:
  case ErrorCode::missing_input:
  case ErrorCode::unavailable:
  case ErrorCode::io:
    return {static_cast<ErrorCode>(code), message};
  default:
    return nonsense("an unknown error code");
  }
}

Status get_attribute(Reader& reader, std::uint64_t vertices, geometry::SurfaceMesh& mesh) {
  geometry::VertexAttribute attribute;
  attribute.name = reader.get_text();
  const auto components = reader.get<std::uint32_t>();
  if (!reader.ok() || attribute.name.empty() || components == 0 || components > MAX_COMPONENTS ||
      vertices > reader.left() / sizeof(double) / components)
    return nonsense("a broken attribute");
  attribute.components = static_cast<int>(components);
  attribute.values.resize(vertices * components);
  reader.get_array(attribute.values.data(), attribute.values.size());
  mesh.attributes.push_back(std::move(attribute));
  return {};
}

Status get_motion(Reader& reader, RawMotion& motion) {
  const auto samples = reader.get<std::uint64_t>();
  motion.camera_fov = reader.get<double>();
  reader.get_array(motion.rest.data(), motion.rest.size());
  if (!reader.ok() || samples > MAX_MOTION_SAMPLES || samples * 17 * sizeof(double) > reader.left() ||
      !std::isfinite(motion.camera_fov))
    return nonsense("a broken motion");
  motion.times.resize(samples);
  motion.transforms.resize(samples);
  reader.get_array(motion.times.data(), samples);
  reader.get_array(motion.transforms.data(), samples);
  return {};
}

void put_materials(std::string& bytes, const RawMesh& raw) {
  put(bytes, static_cast<std::uint64_t>(raw.material_of_triangle.size()));
  put_array(bytes, raw.material_of_triangle.data(), raw.material_of_triangle.size());
  put(bytes, static_cast<std::uint64_t>(raw.materials.size()));
  for (const render::ArtistMaterial& material : raw.materials) {
    put_text(bytes, material.name);
    put_array(bytes, material.base_colour.data(), 3);
    put(bytes, material.roughness);
    put(bytes, material.metallic);
    put(bytes, static_cast<std::int32_t>(material.texture));
  }
  put(bytes, static_cast<std::uint64_t>(raw.textures.size()));
  for (const render::Image& texture : raw.textures) {
    put(bytes, static_cast<std::int32_t>(texture.width));
    put(bytes, static_cast<std::int32_t>(texture.height));
    put_array(bytes, texture.pixels.data(), texture.pixels.size());
  }
}

Status get_material(Reader& reader, std::int32_t textures, RawMesh& raw) {
  const auto unit = [](float v) { return v >= 0.f && v <= 1.f; };
  render::ArtistMaterial material;
  material.name = reader.get_text();
  reader.get_array(material.base_colour.data(), 3);
  material.roughness = reader.get<float>();
  material.metallic = reader.get<float>();
  material.texture = reader.get<std::int32_t>();
  if (!reader.ok() || !unit(material.base_colour[0]) || !unit(material.base_colour[1]) ||
      !unit(material.base_colour[2]) || !unit(material.roughness) || !unit(material.metallic) ||
      material.texture < -1 || material.texture >= textures)
    return nonsense("a broken material");
  raw.materials.push_back(std::move(material));
  return {};
}

Status get_texture(Reader& reader, RawMesh& raw) {
  const auto width = reader.get<std::int32_t>();
  const auto height = reader.get<std::int32_t>();
  if (!reader.ok() || width < 1 || height < 1 || width > MAX_SIDE || height > MAX_SIDE ||
      static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) * 4 > reader.left())
    return nonsense("a broken picture");
  render::Image image(width, height);
  reader.get_array(image.pixels.data(), image.pixels.size());
  raw.textures.push_back(std::move(image));
  return {};
}

Status get_materials(Reader& reader, RawMesh& raw) {
  const auto rows = reader.get<std::uint64_t>();
  if (!reader.ok() || (rows != 0 && rows != static_cast<std::uint64_t>(raw.mesh.triangles.rows())) ||
      rows > reader.left() / sizeof(std::int32_t))
    return nonsense("a wrong number of materials");
  raw.material_of_triangle.resize(rows);
  reader.get_array(raw.material_of_triangle.data(), rows);
  const auto materials = reader.get<std::uint64_t>();
  if (!reader.ok() || materials > MAX_MATERIALS)
    return nonsense("too many materials");
  for (std::uint64_t i = 0; i < materials; ++i) {
    if (Status status = get_material(reader, MAX_TEXTURES, raw); !status)
      return status;
  }
  const auto textures = reader.get<std::uint64_t>();
  if (!reader.ok() || textures > static_cast<std::uint64_t>(MAX_TEXTURES))
    return nonsense("too many pictures");
  for (std::uint64_t i = 0; i < textures; ++i) {
    if (Status status = get_texture(reader, raw); !status)
      return status;
  }
  for (const std::int32_t material : raw.material_of_triangle) {
    if (material < 0 || material >= static_cast<std::int64_t>(raw.materials.size()))
      return nonsense("a material out of range");
  }
  for (const render::ArtistMaterial& material : raw.materials) {
    if (material.texture >= static_cast<std::int64_t>(raw.textures.size()))
      return nonsense("a picture out of range");
  }
  return {};
}

} // namespace

std::string encode_answer(const Result<RawMesh>& answer) {
  std::string bytes;
  if (!answer) {
    bytes.append(FAIL_MAGIC, MAGIC_SIZE);
    put(bytes, static_cast<std::int32_t>(answer.error().code));
    put_text(bytes, answer.error().message);
    return bytes;
  }
  const geometry::SurfaceMesh& mesh = answer->mesh;
  bytes.append(MESH_MAGIC, MAGIC_SIZE);
  put(bytes, static_cast<std::uint64_t>(mesh.vertices.rows()));
  put(bytes, static_cast<std::uint64_t>(mesh.triangles.rows()));
  put(bytes, static_cast<std::uint64_t>(mesh.attributes.size()));
  put(bytes, static_cast<std::uint64_t>(answer->notes.size()));
  put_array(bytes, mesh.vertices.data(), static_cast<std::size_t>(mesh.vertices.size()));
  put_array(bytes, mesh.triangles.data(), static_cast<std::size_t>(mesh.triangles.size()));
  for (const geometry::VertexAttribute& attribute : mesh.attributes) {
    put_text(bytes, attribute.name);
    put(bytes, static_cast<std::uint32_t>(attribute.components));
    put_array(bytes, attribute.values.data(), attribute.values.size());
  }
  for (const std::string& note : answer->notes)
    put_text(bytes, note);
  const RawMotion& motion = answer->motion;
  put(bytes, static_cast<std::uint64_t>(motion.times.size()));
  put(bytes, motion.camera_fov);
  put_array(bytes, motion.rest.data(), motion.rest.size());
  put_array(bytes, motion.times.data(), motion.times.size());
  put_array(bytes, motion.transforms.data(), motion.transforms.size());
  put_materials(bytes, *answer);
  return bytes;
}

Result<RawMesh> decode_answer(std::span<const std::byte> bytes) {
  Reader reader(bytes);
  char magic[MAGIC_SIZE] = {};
  reader.get_array(magic, MAGIC_SIZE);
  if (reader.ok() && std::memcmp(magic, FAIL_MAGIC, MAGIC_SIZE) == 0)
    return get_failure(reader);
  if (!reader.ok() || std::memcmp(magic, MESH_MAGIC, MAGIC_SIZE) != 0)
    return nonsense(bytes.empty() ? "it is empty" : "it does not begin as one");
  const auto vertices = reader.get<std::uint64_t>();
  const auto triangles = reader.get<std::uint64_t>();
  const auto attributes = reader.get<std::uint64_t>();
  const auto notes = reader.get<std::uint64_t>();
  constexpr std::uint64_t MAX_ROWS = std::numeric_limits<std::int32_t>::max() / 3;
  if (!reader.ok() || vertices > MAX_ROWS || triangles > MAX_ROWS || attributes > MAX_ATTRIBUTES || notes > MAX_NOTES)
    return nonsense("counts out of range");
  if (vertices * 3 * sizeof(double) + triangles * 3 * sizeof(std::int32_t) > reader.left())
    return nonsense("counts beyond its end");
  RawMesh raw;
  raw.mesh.vertices.resize(static_cast<Eigen::Index>(vertices), 3);
  raw.mesh.triangles.resize(static_cast<Eigen::Index>(triangles), 3);
  reader.get_array(raw.mesh.vertices.data(), vertices * 3);
  reader.get_array(raw.mesh.triangles.data(), triangles * 3);
  if (triangles > 0 &&
      (raw.mesh.triangles.minCoeff() < 0 || raw.mesh.triangles.maxCoeff() >= static_cast<std::int64_t>(vertices)))
    return nonsense("vertex indices out of range");
  for (std::uint64_t i = 0; i < attributes; ++i)
    if (Status status = get_attribute(reader, vertices, raw.mesh); !status)
      return status.error();
  for (std::uint64_t i = 0; i < notes; ++i)
    raw.notes.push_back(reader.get_text());
  if (Status status = get_motion(reader, raw.motion); !status)
    return status.error();
  if (Status status = get_materials(reader, raw); !status)
    return status.error();
  if (!reader.at_end())
    return nonsense("its length is wrong");
  return raw;
}

} // namespace wry::pipeline
