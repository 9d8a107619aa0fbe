#include "pipeline/assets/ply_reader.h"

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "pipeline/assets/ply_header.h"
#include "pipeline/assets/polygon.h"

namespace wry::pipeline {

namespace {

constexpr std::uint64_t MAX_ROWS = std::numeric_limits<std::int32_t>::max() / 3;

template <class T> double load(const char* bytes, bool swap) {
  std::array<char, sizeof(T)> raw{};
  for (std::size_t i = 0; i < sizeof(T); ++i)
    raw[i] = bytes[swap ? sizeof(T) - 1 - i : i];
  return static_cast<double>(std::bit_cast<T>(raw));
}

// Gives the values of the data part one after the other.
class Values {
public:
  Values(std::string_view bytes, const PlyHeader& header)
      : m_bytes(bytes)
      , m_at(header.size)
      , m_line(header.lines + 1)
      , m_format(header.format) {}

  std::size_t left() const { return m_bytes.size() - m_at; }

  /// "line 7" or "byte 1234".
  std::string place() const {
    return m_format == PlyFormat::ascii ? fmt::format("line {}", m_line) : fmt::format("byte {}", m_at);
  }

  Result<double> next(PlyType type) { return m_format == PlyFormat::ascii ? next_word() : next_binary(type); }

private:
  Result<double> next_binary(PlyType type) {
    if (ply_size(type) > left())
      return make_error(ErrorCode::bad_input, "the file ends early, at byte {}: it is truncated", m_bytes.size());
    const char* from = m_bytes.data() + m_at;
    const bool swap = m_format == PlyFormat::big_endian;
    m_at += ply_size(type);
    switch (type) {
    case PlyType::i8:
      return load<std::int8_t>(from, swap);
    case PlyType::u8:
      return load<std::uint8_t>(from, swap);
    case PlyType::i16:
      return load<std::int16_t>(from, swap);
    case PlyType::u16:
      return load<std::uint16_t>(from, swap);
    case PlyType::i32:
      return load<std::int32_t>(from, swap);
    case PlyType::u32:
      return load<std::uint32_t>(from, swap);
    case PlyType::f32:
      return load<float>(from, swap);
    default:
      return load<double>(from, swap);
    }
  }

  Result<double> next_word() {
    while (m_at < m_bytes.size() && static_cast<unsigned char>(m_bytes[m_at]) <= ' ') {
      m_line += m_bytes[m_at] == '\n';
      ++m_at;
    }
    if (m_at >= m_bytes.size())
      return make_error(ErrorCode::bad_input, "the file ends early, at line {}: it is truncated", m_line);
    std::size_t end = m_at;
    while (end < m_bytes.size() && static_cast<unsigned char>(m_bytes[end]) > ' ')
      ++end;
    const char* from = m_bytes.data() + m_at + (m_bytes[m_at] == '+');
    const char* to = m_bytes.data() + end;
    double value = 0;
    const auto [stop, error] = std::from_chars(from, to, value);
    if (error == std::errc::result_out_of_range) {
      const bool is_tiny = std::string_view(from, to).find("e-") != std::string_view::npos ||
                           std::string_view(from, to).find("E-") != std::string_view::npos;
      value = is_tiny ? 0.0 : std::numeric_limits<double>::infinity();
    }
    if (stop != to || (error != std::errc{} && error != std::errc::result_out_of_range))
      return make_error(ErrorCode::bad_input, "line {}: not a number", m_line);
    m_at = end;
    return value;
  }

  std::string_view m_bytes;
  std::size_t m_at;
  std::size_t m_line;
  PlyFormat m_format;
};

// Where the value of a vertex property goes.
struct Column {
  enum class Kind { skip, position, attribute } kind = Kind::skip;
  std::size_t attribute = 0;
  int component = 0;
  double factor = 1;
};

double colour_factor(PlyType type) {
  return type == PlyType::u8 ? 1.0 / 255 : type == PlyType::u16 ? 1.0 / 65535 : 1.0;
}

class Reader {
public:
  Reader(std::string_view bytes, const PlyHeader& header)
      : m_header(header)
      , m_values(bytes, header) {}

  Result<RawMesh> read() {
    for (const PlyElement& element : m_header.elements) {
      if (Status status = check_count(element); !status)
        return status.error();
      Status status = element.name == "vertex" ? read_vertices(element)
                      : element.name == "face" ? read_faces(element)
                                               : skip(element);
      if (!status)
        return status.error();
    }
    return finish();
  }

private:
  // So that nothing is reserved for what is not there: an ASCII value takes at least a digit and a blank.
  Status check_count(const PlyElement& element) const {
    const std::size_t least =
        m_header.format == PlyFormat::ascii ? 2 * element.properties.size() : element.least_size();
    if (element.properties.empty() ||
        (least > 0 && element.count <= (m_values.left() + 1) / least && element.count <= MAX_ROWS))
      return {};
    return make_error(
        ErrorCode::bad_input,
        "the header promises {} x '{}', but the {} bytes that follow cannot hold them: truncated or damaged",
        element.count, element.name.substr(0, 40), m_values.left());
  }

  std::size_t attribute(const std::string& name, int components) {
    auto& attributes = m_raw.mesh.attributes;
    std::string free_name = name;
    for (std::size_t i = 0; i < attributes.size(); ++i) {
      if (attributes[i].name != free_name)
        continue;
      if (attributes[i].components == components && components > 1)
        return i;
      // A scalar that is called like one of our own attributes: look again under another name.
      free_name += "_";
      i = static_cast<std::size_t>(-1);
    }
    attributes.push_back({free_name, components, {}});
    return attributes.size() - 1;
  }

  Column column_of(const PlyProperty& property) {
    constexpr std::array<std::array<std::string_view, 3>, 3> COLOURS = {
        {{"red", "green", "blue"}, {"r", "g", "b"}, {"diffuse_red", "diffuse_green", "diffuse_blue"}}};
    constexpr std::array<std::array<std::string_view, 2>, 4> TEXTURES = {
        {{"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}}};
    const std::string_view name = property.name;
    if (property.is_list || name == "nx" || name == "ny" || name == "nz" || name == "alpha" || name == "a")
      return {};
    for (int i = 0; i < 3; ++i)
      if (name == std::string_view(&"xyz"[i], 1))
        return {Column::Kind::position, 0, i, 1};
    for (const auto& names : COLOURS)
      for (int i = 0; i < 3; ++i)
        if (name == names[i])
          return {Column::Kind::attribute, attribute("colour", 3), i, colour_factor(property.type)};
    for (const auto& names : TEXTURES)
      for (int i = 0; i < 2; ++i)
        if (name == names[i])
          return {Column::Kind::attribute, attribute("uv", 2), i, 1};
    return {Column::Kind::attribute, attribute(property.name, 1), 0, 1};
  }

  Status read_vertices(const PlyElement& element) {
    if (m_raw.mesh.vertices.rows() > 0)
      return make_error(ErrorCode::bad_input, "the element 'vertex' comes twice");
    std::vector<Column> columns;
    int positions = 0;
    for (const PlyProperty& property : element.properties) {
      columns.push_back(column_of(property));
      positions += columns.back().kind == Column::Kind::position;
    }
    if (positions != 3)
      return make_error(ErrorCode::bad_input, "the vertices lack x, y or z");
    m_raw.mesh.vertices.resize(static_cast<Eigen::Index>(element.count), 3);
    for (geometry::VertexAttribute& values : m_raw.mesh.attributes)
      values.values.assign(element.count * static_cast<std::size_t>(values.components), 0.0);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      for (std::size_t k = 0; k < columns.size(); ++k) {
        if (element.properties[k].is_list) {
          if (Status status = read_list(element.properties[k]); !status)
            return status;
          continue;
        }
        const Result<double> value = m_values.next(element.properties[k].type);
        if (!value)
          return in_element(value.error(), "vertex", i, element.count);
        store(columns[k], i, *value);
      }
    }
    return {};
  }

  void store(const Column& column, std::uint64_t vertex, double value) {
    if (column.kind == Column::Kind::position)
      m_raw.mesh.vertices(static_cast<Eigen::Index>(vertex), column.component) = value;
    else if (column.kind == Column::Kind::attribute) {
      geometry::VertexAttribute& target = m_raw.mesh.attributes[column.attribute];
      target.values[vertex * static_cast<std::size_t>(target.components) + static_cast<std::size_t>(column.component)] =
          column.factor * value;
    }
  }

  static Error in_element(const Error& error, const char* what, std::uint64_t index, std::uint64_t count) {
    return {error.code, fmt::format("{} {} of {}: {}", what, index + 1, count, error.message)};
  }

  // Into m_list.
  Status read_list(const PlyProperty& property) {
    const Result<double> count = m_values.next(property.count_type);
    if (!count)
      return count.error();
    const std::size_t least = m_header.format == PlyFormat::ascii ? 2 : ply_size(property.type);
    if (!(*count >= 0) || *count != std::floor(*count) || *count > static_cast<double>((m_values.left() + 1) / least))
      return make_error(ErrorCode::bad_input,
                        "{}: a list of {} values does not fit the rest of the file: it is cut short or damaged",
                        m_values.place(), *count);
    m_list.clear();
    for (auto i = static_cast<std::size_t>(*count); i > 0; --i) {
      const Result<double> value = m_values.next(property.type);
      if (!value)
        return value.error();
      m_list.push_back(*value);
    }
    return {};
  }

  Status read_faces(const PlyElement& element) {
    for (std::uint64_t i = 0; i < element.count; ++i) {
      for (const PlyProperty& property : element.properties) {
        if (!property.is_list) {
          const Result<double> value = m_values.next(property.type);
          if (!value)
            return in_element(value.error(), "face", i, element.count);
          continue;
        }
        Status status = read_list(property);
        const bool is_corners = property.name == "vertex_indices" || property.name == "vertex_index";
        if (status && is_corners)
          status = add_face();
        if (!status)
          return in_element(status.error(), "face", i, element.count);
      }
    }
    return {};
  }

  Status add_face() {
    if (m_list.size() < 3) {
      ++m_thin_faces;
      return {};
    }
    // Faces may come before the vertices, so indices are checked against their number at the end.
    m_corners.clear();
    for (const double value : m_list) {
      if (!(value >= 0) || value != std::floor(value) || value > static_cast<double>(MAX_ROWS))
        return make_error(ErrorCode::bad_input, "{}: {} is no vertex index", m_values.place(), value);
      m_corners.push_back(static_cast<std::int32_t>(value));
    }
    m_polygons.insert(m_polygons.end(), m_corners.begin(), m_corners.end());
    m_polygon_ends.push_back(m_polygons.size());
    return {};
  }

  Status skip(const PlyElement& element) {
    if (element.name == "tristrips")
      return make_error(ErrorCode::bad_input, "triangle strips are not read; export single faces");
    if (element.properties.empty())
      return {};
    for (std::uint64_t i = 0; i < element.count; ++i) {
      for (const PlyProperty& property : element.properties) {
        if (property.is_list) {
          if (Status status = read_list(property); !status)
            return status;
        } else if (const Result<double> value = m_values.next(property.type); !value) {
          return value.error();
        }
      }
    }
    return {};
  }

  Result<RawMesh> finish() {
    const auto vertices = m_raw.mesh.vertices.rows();
    std::vector<std::array<std::int32_t, 3>> triangles;
    std::vector<Vec3> points;
    std::size_t begin = 0;
    for (std::size_t face = 0; face < m_polygon_ends.size(); ++face) {
      const std::span corners(m_polygons.data() + begin, m_polygon_ends[face] - begin);
      begin = m_polygon_ends[face];
      points.clear();
      for (const std::int32_t corner : corners) {
        if (corner >= vertices)
          return make_error(ErrorCode::bad_input, "face {} of {} names vertex {}, but there are only 0..{}", face + 1,
                            m_polygon_ends.size(), corner, vertices - 1);
        points.emplace_back(m_raw.mesh.vertices.row(corner).transpose());
      }
      const auto cut = triangulate_polygon(corners, points);
      triangles.insert(triangles.end(), cut.begin(), cut.end());
    }
    if (triangles.empty())
      return make_error(ErrorCode::bad_input, "there are {} vertices, but no faces", vertices);
    if (m_thin_faces > 0)
      m_raw.notes.push_back(fmt::format("{} faces with fewer than three corners were left out", m_thin_faces));
    m_raw.mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (int k = 0; k < 3; ++k)
        m_raw.mesh.triangles(static_cast<Eigen::Index>(t), k) = triangles[t][k];
    return std::move(m_raw);
  }

  const PlyHeader& m_header;
  Values m_values;
  RawMesh m_raw;
  std::vector<double> m_list;
  std::vector<std::int32_t> m_corners;
  std::vector<std::int32_t> m_polygons;
  std::vector<std::size_t> m_polygon_ends;
  std::int64_t m_thin_faces = 0;
};

} // namespace

Result<RawMesh> read_ply(std::string_view bytes) {
  const Result<PlyHeader> header = read_ply_header(bytes);
  if (!header)
    return header.error();
  return Reader(bytes, *header).read();
}

} // namespace wry::pipeline
