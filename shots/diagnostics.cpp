#include "shots/diagnostics.h"

#include <algorithm>
#include <tuple>

#include "shots/load.h"

namespace wry::shots {
namespace {

/// A message is a line, whatever a file put into its names.
std::string one_line(std::string text) {
  for (char& c : text) {
    const auto byte = static_cast<unsigned char>(c);
    c = byte < 0x20 || byte == 0x7f ? ' ' : c;
  }
  return text;
}

} // namespace

void Diagnostics::add(Source source, std::string message) {
  ++m_count;
  if (!full()) {
    m_list.push_back(Diagnostic{std::move(source), std::move(message)});
  }
}

bool Diagnostics::full() const {
  return m_list.size() >= static_cast<std::size_t>(MAX_ERRORS);
}

bool Diagnostics::any_under(const std::string& key) const {
  return full() || std::any_of(m_list.begin(), m_list.end(), [&](const Diagnostic& diagnostic) {
           const std::string& other = diagnostic.source.key;
           return other.compare(0, key.size(), key) == 0 &&
                  (other.size() == key.size() || other[key.size()] == '.' || other[key.size()] == '[');
         });
}

Error Diagnostics::error() const {
  std::vector<Diagnostic> sorted = m_list;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Diagnostic& a, const Diagnostic& b) {
    return std::tie(a.source.file, a.source.line, a.source.column) <
           std::tie(b.source.file, b.source.line, b.source.column);
  });
  std::string text;
  for (const Diagnostic& diagnostic : sorted) {
    text += fmt::format("{}{}", text.empty() ? "" : "\n", one_line(diagnostic.source.text() + diagnostic.message));
  }
  if (m_count > m_list.size()) {
    text += fmt::format("\nand {} more errors", m_count - m_list.size());
  }
  return Error{ErrorCode::bad_input, text};
}

} // namespace wry::shots
