#include "pipeline/assets/numbered_vertices.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "pipeline/assets/ply_reader.h"
#include "pipeline/cache/atomic_file.h"

namespace wry::pipeline {

namespace {

/// Ends the corners of a face.
constexpr std::int32_t END_OF_FACE = -1;

/// The next word of a line, or nothing.
std::string_view next_word(std::string_view& line) {
  const std::size_t begin = line.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos)
    return {};
  const std::size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

class ObjReader {
public:
  Result<NumberedVertices> read(std::string_view text) {
    for (int number = 1; !text.empty(); ++number) {
      const std::size_t end = text.find('\n');
      std::string_view line = text.substr(0, end);
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
      const std::string_view what = next_word(line);
      const bool good = what == "v" ? read_vertex(line) : what == "f" ? read_face(line) : true;
      if (!good)
        return make_error(ErrorCode::bad_input, "line {}: '{}' with what follows is no {}", number, what,
                          what == "v" ? "vertex of three numbers" : "face of the vertices before it");
    }
    if (m_coordinates.empty())
      return make_error(ErrorCode::bad_input, "there are no vertices");
    m_made.positions = Eigen::Map<const Points>(m_coordinates.data(), vertex_count(), 3);
    return std::move(m_made);
  }

private:
  Eigen::Index vertex_count() const { return static_cast<Eigen::Index>(m_coordinates.size() / 3); }

  bool read_vertex(std::string_view line) {
    for (int i = 0; i < 3; ++i) {
      std::string_view word = next_word(line);
      if (word.starts_with('+'))
        word.remove_prefix(1);
      double value = 0.0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
      if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
        return false;
      m_coordinates.push_back(value);
    }
    return true;
  }

  /// Corners such as 7, 7/1, 7//3, or -1 for the last vertex so far.
  bool read_face(std::string_view line) {
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      std::int64_t index = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
      if (error != std::errc() || (end != word.data() + word.size() && *end != '/'))
        return false;
      const std::int64_t vertex = index < 0 ? vertex_count() + index : index - 1;
      if (vertex < 0 || vertex >= vertex_count())
        return false;
      m_made.faces.push_back(static_cast<std::int32_t>(vertex));
    }
    m_made.faces.push_back(END_OF_FACE);
    return true;
  }

  std::vector<double> m_coordinates;
  NumberedVertices m_made;
};

Result<NumberedVertices> read_ply_vertices(std::string_view bytes) {
  Result<RawMesh> raw = read_ply(bytes);
  if (!raw)
    return std::move(raw).error();
  NumberedVertices made;
  made.positions = std::move(raw->mesh.vertices);
  made.faces = {static_cast<std::int32_t>(raw->mesh.triangles.rows())};
  if (!made.positions.allFinite())
    return make_error(ErrorCode::bad_input, "a coordinate is no finite number");
  return made;
}

} // namespace

Result<NumberedVertices> read_numbered_vertices(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension != ".obj" && extension != ".ply")
    return make_error(ErrorCode::bad_input,
                      "{}: only .obj and .ply files number their vertices in an order that lasts; export one of them",
                      path.string());
  const Result<std::string> bytes = read_whole_file(path);
  if (!bytes)
    return bytes.error();
  Result<NumberedVertices> made = extension == ".obj" ? ObjReader().read(*bytes) : read_ply_vertices(*bytes);
  if (!made)
    return make_error(made.error().code, "{}: {}", path.string(), made.error().message);
  return made;
}

} // namespace wry::pipeline
