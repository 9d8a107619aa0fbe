#include "pipeline/assets/ply_header.h"

#include <array>
#include <charconv>
#include <optional>
#include <utility>

namespace wry::pipeline {

namespace {

constexpr std::size_t MAX_LINES = 2000;
constexpr std::size_t MAX_LINE = 4096;
constexpr std::size_t MAX_PROPERTIES = 256;

std::optional<PlyType> parse_type(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, PlyType>, 16> TYPES = {{{"char", PlyType::i8},
                                                                           {"int8", PlyType::i8},
                                                                           {"uchar", PlyType::u8},
                                                                           {"uint8", PlyType::u8},
                                                                           {"short", PlyType::i16},
                                                                           {"int16", PlyType::i16},
                                                                           {"ushort", PlyType::u16},
                                                                           {"uint16", PlyType::u16},
                                                                           {"int", PlyType::i32},
                                                                           {"int32", PlyType::i32},
                                                                           {"uint", PlyType::u32},
                                                                           {"uint32", PlyType::u32},
                                                                           {"float", PlyType::f32},
                                                                           {"float32", PlyType::f32},
                                                                           {"double", PlyType::f64},
                                                                           {"float64", PlyType::f64}}};
  for (const auto& [known, type] : TYPES)
    if (known == name)
      return type;
  return std::nullopt;
}

bool is_integer(PlyType type) {
  return type != PlyType::f32 && type != PlyType::f64;
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t i = 0; i < line.size();) {
    const std::size_t begin = line.find_first_not_of(" \t", i);
    if (begin == std::string_view::npos)
      break;
    const std::size_t end = std::min(line.find_first_of(" \t", begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    i = end;
  }
  return words;
}

std::string printable(std::string_view text) {
  std::string result;
  for (const char c : text.substr(0, 40))
    result += c >= 0x20 && c < 0x7f ? c : '?';
  return result;
}

// The next line without its end ("\n", "\r\n" or "\r"), or nothing when the text ends first.
std::optional<std::string_view> next_line(std::string_view bytes, std::size_t& at) {
  const std::size_t end = bytes.substr(0, std::min(bytes.size(), at + MAX_LINE)).find_first_of("\r\n", at);
  if (end == std::string_view::npos)
    return std::nullopt;
  const std::string_view line = bytes.substr(at, end - at);
  at = end + 1;
  if (bytes[end] == '\r' && at < bytes.size() && bytes[at] == '\n')
    ++at;
  return line;
}

using Words = std::vector<std::string_view>;

Status add_element(const Words& words, std::size_t line, PlyHeader& header) {
  PlyElement element;
  if (words.size() == 3) {
    element.name = words[1];
    const auto [end, error] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
    if (error == std::errc{} && end == words[2].data() + words[2].size()) {
      header.elements.push_back(std::move(element));
      return {};
    }
  }
  return make_error(ErrorCode::bad_input, "line {}: an element needs a name and a count", line);
}

Status add_property(const Words& words, std::size_t line, PlyHeader& header) {
  if (header.elements.empty())
    return make_error(ErrorCode::bad_input, "line {}: a property before any element", line);
  PlyProperty property;
  property.is_list = words.size() == 5 && words[1] == "list";
  const std::optional<PlyType> type = property.is_list    ? parse_type(words[3])
                                      : words.size() == 3 ? parse_type(words[1])
                                                          : std::nullopt;
  if (!type)
    return make_error(ErrorCode::bad_input, "line {}: a property needs a known type and a name", line);
  if (property.is_list) {
    const std::optional<PlyType> count_type = parse_type(words[2]);
    if (!count_type || !is_integer(*count_type))
      return make_error(ErrorCode::bad_input, "line {}: a list needs an integer type for its count", line);
    property.count_type = *count_type;
  }
  property.type = *type;
  property.name = words.back();
  std::vector<PlyProperty>& properties = header.elements.back().properties;
  if (properties.size() >= MAX_PROPERTIES)
    return make_error(ErrorCode::bad_input, "line {}: more than {} properties", line, MAX_PROPERTIES);
  for (const PlyProperty& other : properties)
    if (other.name == property.name)
      return make_error(ErrorCode::bad_input, "line {}: the property '{}' comes twice", line, printable(property.name));
  properties.push_back(std::move(property));
  return {};
}

Status set_format(const Words& words, std::size_t line, PlyHeader& header) {
  if (words.size() == 3 && words[2] == "1.0") {
    header.format = words[1] == "binary_little_endian" ? PlyFormat::little_endian
                    : words[1] == "binary_big_endian"  ? PlyFormat::big_endian
                                                       : PlyFormat::ascii;
    if (header.format != PlyFormat::ascii || words[1] == "ascii")
      return {};
  }
  return make_error(ErrorCode::bad_input,
                    "line {}: the format is none of ascii, binary_little_endian, binary_big_endian 1.0", line);
}

} // namespace

std::size_t ply_size(PlyType type) {
  switch (type) {
  case PlyType::i8:
  case PlyType::u8:
    return 1;
  case PlyType::i16:
  case PlyType::u16:
    return 2;
  case PlyType::f64:
    return 8;
  default:
    return 4;
  }
}

std::size_t PlyElement::least_size() const {
  std::size_t size = 0;
  for (const PlyProperty& property : properties)
    size += ply_size(property.is_list ? property.count_type : property.type);
  return size;
}

Result<PlyHeader> read_ply_header(std::string_view bytes) {
  PlyHeader header;
  std::size_t at = 0;
  const std::optional<std::string_view> magic = next_line(bytes, at);
  if (!magic || *magic != "ply")
    return make_error(ErrorCode::bad_input, "line 1: a PLY file begins with 'ply'");
  bool has_format = false;
  for (std::size_t number = 2; number <= MAX_LINES; ++number) {
    const std::optional<std::string_view> line = next_line(bytes, at);
    if (!line)
      return make_error(ErrorCode::bad_input, "line {}: the header ends before 'end_header'", number);
    const Words words = words_of(*line);
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info")
      continue;
    Status status;
    if (words[0] == "end_header") {
      if (!has_format)
        return make_error(ErrorCode::bad_input, "line {}: the header has no format", number);
      header.size = at;
      header.lines = number;
      return header;
    }
    if (words[0] == "format") {
      status = set_format(words, number, header);
      has_format = true;
    } else if (words[0] == "element") {
      status = add_element(words, number, header);
    } else if (words[0] == "property") {
      status = add_property(words, number, header);
    } else {
      status =
          make_error(ErrorCode::bad_input, "line {}: '{}' has no place in a PLY header", number, printable(words[0]));
    }
    if (!status)
      return status.error();
  }
  return make_error(ErrorCode::bad_input, "the header has more than {} lines", MAX_LINES);
}

} // namespace wry::pipeline
