#include "pipeline/assets/file_checks.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>

namespace wry::pipeline {

namespace {

std::uint32_t read_u32(std::string_view bytes, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i]));
  };
  return byte(0) | byte(1) << 8 | byte(2) << 16 | byte(3) << 24;
}

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

// Splits off the first word of a line.
std::string_view take_word(std::string_view& line) {
  std::size_t begin = 0;
  while (begin < line.size() && is_blank(line[begin]))
    ++begin;
  std::size_t end = begin;
  while (end < line.size() && !is_blank(line[end]))
    ++end;
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

// Lines of a text, numbered from 1.
class Lines {
public:
  explicit Lines(std::string_view text)
      : m_text(text) {}

  bool next(std::string_view& line) {
    if (m_at >= m_text.size())
      return false;
    const std::size_t end = m_text.find('\n', m_at);
    m_has_break = end != std::string_view::npos;
    line = m_text.substr(m_at, m_has_break ? end - m_at : std::string_view::npos);
    m_at = m_has_break ? end + 1 : m_text.size();
    ++m_number;
    return true;
  }

  std::size_t number() const { return m_number; }
  bool has_break() const { return m_has_break; }

private:
  std::string_view m_text;
  std::size_t m_at = 0;
  std::size_t m_number = 0;
  bool m_has_break = true;
};

class ObjCheck {
public:
  explicit ObjCheck(std::string_view text)
      : m_lines(text) {}

  Status run(std::vector<std::string>& notes) {
    std::string_view line;
    bool continues = false;
    while (m_lines.next(line)) {
      const bool was_continued = continues;
      continues =
          line.find_last_not_of(" \t\r") != std::string_view::npos && line[line.find_last_not_of(" \t\r")] == '\\';
      if (was_continued || continues) {
        m_lines_continued = true; // a statement over several lines is left to the reader
        continue;
      }
      std::string_view rest = line;
      const std::string_view keyword = take_word(rest);
      Status status;
      if (keyword == "v")
        status = check_vertex(rest);
      else if (keyword == "f")
        status = check_face(rest);
      if (!status)
        return status;
      m_last_keyword = keyword.empty() ? m_last_keyword : keyword;
    }
    // With continued lines the vertices that were seen are not all.
    if (m_highest > m_vertices && !m_lines_continued)
      return make_error(ErrorCode::bad_input,
                        "line {}: a face names vertex {}, but the file has only {}: it is damaged or cut short",
                        m_highest_line, m_highest, m_vertices);
    if (!m_lines.has_break() && (m_last_keyword == "f" || m_last_keyword == "v"))
      notes.emplace_back("the file ends in the middle of a line: it may have been cut short");
    if (m_faces == 0)
      return make_error(ErrorCode::bad_input, "there are {} vertices, but no faces: it is damaged or cut short",
                        m_vertices);
    return {};
  }

private:
  Status check_vertex(std::string_view rest) {
    ++m_vertices;
    for (int i = 0; i < 3; ++i) {
      const std::string_view word = take_word(rest);
      double value = 0;
      const std::size_t skip = !word.empty() && word[0] == '+';
      const auto [end, error] = std::from_chars(word.data() + skip, word.data() + word.size(), value);
      if (word.empty() || error == std::errc::invalid_argument)
        return make_error(ErrorCode::bad_input,
                          "line {}: a vertex needs three numbers: the file is damaged or cut short", m_lines.number());
    }
    return {};
  }

  Status check_face(std::string_view rest) {
    ++m_faces;
    int corners = 0;
    for (std::string_view word = take_word(rest); !word.empty() && word[0] != '#'; word = take_word(rest)) {
      std::int64_t index = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
      if (error != std::errc{} || index == 0)
        return make_error(ErrorCode::bad_input, "line {}: a face needs vertex numbers: the file is damaged",
                          m_lines.number());
      if (index < 0 && -index > m_vertices)
        return make_error(ErrorCode::bad_input,
                          "line {}: a face names the {}th vertex before it, but there are only {}", m_lines.number(),
                          -index, m_vertices);
      if (index > m_highest) {
        m_highest = index;
        m_highest_line = m_lines.number();
      }
      ++corners;
    }
    if (corners < 3)
      return make_error(ErrorCode::bad_input,
                        "line {}: a face needs three corners, it has {}: the file is damaged or cut short",
                        m_lines.number(), corners);
    return {};
  }

  Lines m_lines;
  std::int64_t m_vertices = 0;
  std::int64_t m_faces = 0;
  std::int64_t m_highest = 0;
  std::size_t m_highest_line = 0;
  bool m_lines_continued = false;
  std::string_view m_last_keyword;
};

Status check_stl(std::string_view bytes) {
  constexpr std::size_t HEADER = 84;
  constexpr std::uint64_t FACET = 50;
  const std::uint64_t promised = bytes.size() >= HEADER ? HEADER + FACET * read_u32(bytes, 80) : 0;
  if (promised > HEADER && promised == bytes.size())
    return {};
  if (bytes.substr(0, 5) == "solid" && bytes.find("facet") != std::string_view::npos) {
    if (bytes.find("endsolid") == std::string_view::npos)
      return make_error(ErrorCode::bad_input, "the text has no 'endsolid': the file is cut short");
    return {};
  }
  if (bytes.size() < HEADER)
    return make_error(ErrorCode::bad_input, "{} bytes are too few for an STL file", bytes.size());
  if (promised > bytes.size())
    return make_error(ErrorCode::bad_input,
                      "its header promises {} triangles, {} bytes, but the file has {}: it is cut short",
                      read_u32(bytes, 80), promised, bytes.size());
  return {};
}

Status check_off(std::string_view bytes) {
  Lines lines(bytes);
  std::string_view line;
  std::uint64_t found = 0;
  std::uint64_t promised = 0;
  bool has_counts = false;
  while (lines.next(line)) {
    line = line.substr(0, line.find('#'));
    std::string_view rest = line;
    std::string_view word = take_word(rest);
    if (word.empty())
      continue;
    if (!has_counts && word.find("OFF") != std::string_view::npos) {
      word = take_word(rest);
      if (word.empty())
        continue;
    }
    if (has_counts) {
      ++found;
      continue;
    }
    std::uint64_t vertices = 0;
    std::uint64_t faces = 0;
    const std::string_view second = take_word(rest);
    if (std::from_chars(word.data(), word.data() + word.size(), vertices).ec != std::errc{} ||
        std::from_chars(second.data(), second.data() + second.size(), faces).ec != std::errc{} ||
        vertices > bytes.size() || faces > bytes.size())
      return make_error(ErrorCode::bad_input, "line {}: the counts of vertices and faces make no sense",
                        lines.number());
    promised = vertices + faces;
    has_counts = true;
  }
  if (!has_counts || found < promised)
    return make_error(ErrorCode::bad_input,
                      "{} lines of vertices and faces are promised, {} are there: the file is cut short", promised,
                      found);
  return {};
}

Status check_glb(std::string_view bytes) {
  if (bytes.size() < 12 || bytes.substr(0, 4) != "glTF")
    return make_error(ErrorCode::bad_input, "it does not begin as a GLB file");
  if (read_u32(bytes, 8) > bytes.size())
    return make_error(ErrorCode::bad_input, "its header promises {} bytes, but the file has {}: it is cut short",
                      read_u32(bytes, 8), bytes.size());
  return {};
}

Status check_3ds(std::string_view bytes) {
  if (bytes.size() < 6 || read_u32(bytes, 2) > bytes.size())
    return make_error(ErrorCode::bad_input, "its first chunk promises more bytes than the file's {}: it is cut short",
                      bytes.size());
  return {};
}

} // namespace

Status check_file(std::string_view bytes, std::string_view extension, std::vector<std::string>& notes) {
  if (bytes.empty())
    return make_error(ErrorCode::bad_input, "the file is empty");
  if (extension == "obj")
    return ObjCheck(bytes).run(notes);
  if (extension == "stl")
    return check_stl(bytes);
  if (extension == "off")
    return check_off(bytes);
  if (extension == "glb")
    return check_glb(bytes);
  if (extension == "3ds")
    return check_3ds(bytes);
  return {};
}

std::string without_trailing_comments(std::string obj) {
  for (std::size_t at = obj.find('#'); at != std::string::npos;) {
    const std::size_t line_break = obj.rfind('\n', at);
    const std::size_t begin = line_break == std::string::npos ? 0 : line_break + 1;
    const std::size_t end = std::min(obj.find('\n', at), obj.size());
    if (obj[begin] == 'f' || obj[begin] == 'v')
      std::fill(obj.begin() + static_cast<std::ptrdiff_t>(at), obj.begin() + static_cast<std::ptrdiff_t>(end), ' ');
    at = obj.find('#', end);
  }
  return obj;
}

} // namespace wry::pipeline
