#pragma once

#include <charconv>
#include <cstdint>
#include <string_view>

#include "sim/base/result.h"

namespace wry::geometry {

/// Numbers of a text, line by line; blank lines are passed over. Every error names the line.
class MshText {
public:
  explicit MshText(std::string_view text)
      : m_text(text) {}

  /// Goes to the next line that is not blank; false at the end.
  bool next_line();

  std::string_view line() const { return m_line; }
  std::size_t number() const { return m_number; }
  std::size_t bytes_left() const { return m_text.size() - m_at; }

  /// Takes the next number of this line.
  template <class T> Result<T> take(const char* what) {
    const std::size_t begin = m_line.find_first_not_of(" \t\r", m_column);
    if (begin == std::string_view::npos)
      return make_error(ErrorCode::bad_input, "line {}: {} is missing", m_number, what);
    const std::size_t end = std::min(m_line.find_first_of(" \t\r", begin), m_line.size());
    const std::size_t sign = m_line[begin] == '+' ? 1 : 0;
    T value{};
    const auto [stop, error] = std::from_chars(m_line.data() + begin + sign, m_line.data() + end, value);
    if (error != std::errc{} || stop != m_line.data() + end)
      return make_error(ErrorCode::bad_input, "line {}: {} is no number that fits: '{}'", m_number, what,
                        printable(m_line.substr(begin, end - begin)));
    m_column = end;
    return value;
  }

  /// Whether nothing follows on this line.
  bool line_is_done() const { return m_line.find_first_not_of(" \t\r", m_column) == std::string_view::npos; }

  /// bad_input for a count of lines that the rest of the text cannot hold.
  Status check_lines(std::uint64_t count, const char* what) const;

  /// "line 7: ...", for errors.
  Error error(std::string_view message) const;

  /// At most 40 characters, without those that a terminal would act on.
  static std::string printable(std::string_view text);

private:
  std::string_view m_text;
  std::string_view m_line;
  std::size_t m_at = 0;
  std::size_t m_number = 0;
  std::size_t m_column = 0;
};

} // namespace wry::geometry
