#include "sim/geometry/msh_import_text.h"

#include <algorithm>

namespace wry::geometry {

bool MshText::next_line() {
  while (m_at < m_text.size()) {
    const std::size_t end = std::min(m_text.find('\n', m_at), m_text.size());
    m_line = m_text.substr(m_at, end - m_at);
    m_at = std::min(end + 1, m_text.size());
    m_column = 0;
    ++m_number;
    const std::size_t last = m_line.find_last_not_of(" \t\r");
    if (last == std::string_view::npos)
      continue;
    m_line = m_line.substr(0, last + 1);
    return true;
  }
  m_line = {};
  return false;
}

Status MshText::check_lines(std::uint64_t count, const char* what) const {
  if (count <= (bytes_left() + 1) / 2)
    return {};
  return make_error(ErrorCode::bad_input,
                    "line {}: {} {} are promised, but only {} bytes follow: the file is cut short or damaged", m_number,
                    count, what, bytes_left());
}

Error MshText::error(std::string_view message) const {
  return make_error(ErrorCode::bad_input, "line {}: {}", m_number, message);
}

std::string MshText::printable(std::string_view text) {
  std::string result(text.substr(0, 40));
  std::replace_if(
      result.begin(), result.end(), [](char c) { return c < 0x20 || c > 0x7e; }, '?');
  return result;
}

} // namespace wry::geometry
