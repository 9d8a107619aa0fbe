#include "shots/load.h"
#include "shots/toml_reader.h"

namespace wry::shots {
namespace {

/// Walks TOML text by its tokens as far as nesting needs: strings and comments are stepped over.
class NestingScanner {
public:
  NestingScanner(std::string_view text, const std::string& file)
      : m_text(text)
      , m_file(file) {}

  Status scan() {
    while (m_at < m_text.size()) {
      const char c = m_text[m_at];
      if (c == '"' || c == '\'') {
        skip_string(c);
        continue;
      }
      if (c == '#') {
        skip_comment();
        continue;
      }
      if (!count(c)) {
        return make_error(ErrorCode::bad_input,
                          "{}:{}:{}: tables, lists or keys nested more than {} deep; a shot needs no more than 6",
                          m_file, m_line, m_column, MAX_DEPTH);
      }
      advance(1);
    }
    return {};
  }

private:
  bool count(char c) {
    switch (c) {
    case '[':
    case '{':
      m_dots = 0;
      return ++m_depth <= MAX_DEPTH;
    case ']':
    case '}':
      m_dots = 0;
      m_depth -= m_depth > 0 ? 1 : 0;
      return true;
    case '.':
      return ++m_dots < MAX_DEPTH;
    case '=':
    case ',':
    case '\n':
      m_dots = 0;
      return true;
    default:
      return true;
    }
  }

  void skip_string(char quote) {
    const bool multi = m_text.substr(m_at, 3) == std::string(3, quote);
    advance(multi ? 3 : 1);
    while (m_at < m_text.size()) {
      const char c = m_text[m_at];
      if (c == '\\' && quote == '"') {
        advance(2);
      } else if (c == '\n' && !multi) {
        return; // unterminated: the parser says so
      } else if (c == quote && (!multi || m_text.substr(m_at, 3) == std::string(3, quote))) {
        advance(multi ? 3 : 1);
        return;
      } else {
        advance(1);
      }
    }
  }

  void skip_comment() {
    while (m_at < m_text.size() && m_text[m_at] != '\n') {
      advance(1);
    }
  }

  void advance(std::size_t count) {
    for (; count > 0 && m_at < m_text.size(); --count, ++m_at) {
      ++m_column;
      if (m_text[m_at] == '\n') {
        ++m_line;
        m_column = 1;
      }
    }
  }

  std::string_view m_text;
  const std::string& m_file;
  std::size_t m_at = 0;
  int m_line = 1, m_column = 1;
  int m_depth = 0, m_dots = 0;
};

} // namespace

Status check_toml_nesting(std::string_view text, const std::string& file) {
  return NestingScanner(text, file).scan();
}

} // namespace wry::shots
