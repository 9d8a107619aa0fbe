#include "pipeline/report/csv.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <fcntl.h>
#include <optional>
#include <unistd.h>
#include <utility>

#include "pipeline/cache/file_error.h"

namespace wry::pipeline {

namespace fs = std::filesystem;

namespace {

std::string header_line(const std::vector<std::string>& columns) {
  std::string line;
  for (const std::string& column : columns)
    line += fmt::format("{}{}", line.empty() ? "" : ",", csv_field(column));
  line += '\n';
  return line;
}

std::optional<std::int64_t> whole_number(const std::string& text) {
  std::int64_t number = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failed != std::errc() || end != text.data() + text.size())
    return std::nullopt;
  return number;
}

struct KeptRows {
  std::string text;
  std::size_t count = 0;
};

/// Header and rows up to the first that is torn, foreign or after `last_kept`.
KeptRows kept_part(std::string_view text, const std::string& header, std::size_t columns, std::size_t key,
                   std::int64_t last_kept) {
  KeptRows kept{header, 0};
  if (!text.starts_with(header))
    return kept;
  text.remove_prefix(header.size());
  for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
    const std::vector<std::string> fields = split_csv_line(text.substr(0, end));
    const std::optional<std::int64_t> number = fields.size() == columns ? whole_number(fields[key]) : std::nullopt;
    if (!number || *number > last_kept)
      break;
    kept.text += text.substr(0, end + 1);
    ++kept.count;
    text.remove_prefix(end + 1);
  }
  return kept;
}

} // namespace

std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos)
    return std::string(text);
  std::string quoted(1, '"');
  for (const char c : text) {
    if (c == '"')
      quoted += '"';
    quoted += c;
  }
  quoted += '"';
  return quoted;
}

std::vector<std::string> split_csv_line(std::string_view line) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    const bool is_doubled = is_quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"';
    if (is_doubled)
      fields.back() += line[++i];
    else if (c == '"')
      is_quoted = !is_quoted;
    else if (c == ',' && !is_quoted)
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

CsvWriter::CsvWriter(fs::path path, std::size_t columns, int file, std::size_t kept_rows)
    : m_path(std::move(path))
    , m_columns(columns)
    , m_kept_rows(kept_rows)
    , m_file(file) {}

CsvWriter::~CsvWriter() {
  if (m_file >= 0)
    ::close(m_file);
}

CsvWriter::CsvWriter(CsvWriter&& other) noexcept
    : m_path(std::move(other.m_path))
    , m_columns(other.m_columns)
    , m_kept_rows(other.m_kept_rows)
    , m_file(std::exchange(other.m_file, -1)) {}

CsvWriter& CsvWriter::operator=(CsvWriter&& other) noexcept {
  std::swap(m_path, other.m_path);
  std::swap(m_columns, other.m_columns);
  std::swap(m_kept_rows, other.m_kept_rows);
  std::swap(m_file, other.m_file);
  return *this;
}

Result<CsvWriter> CsvWriter::open(const fs::path& path, std::vector<std::string> columns, const std::string& key_column,
                                  std::int64_t last_kept) {
  const auto key = std::find(columns.begin(), columns.end(), key_column);
  if (key == columns.end())
    return make_error(ErrorCode::usage, "{}: the column '{}' is not one of its own", path.string(), key_column);
  const Result<std::string> old = read_whole_file(path);
  if (!old && old.error().code != ErrorCode::missing_input)
    return old.error();
  const KeptRows kept = kept_part(old ? *old : std::string(), header_line(columns), columns.size(),
                                  static_cast<std::size_t>(key - columns.begin()), last_kept);
  if (!old || *old != kept.text) {
    if (Status written = write_file_atomically(path, kept.text); !written)
      return written.error();
  }
  const int file = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (file < 0)
    return write_error("write", path, errno);
  return CsvWriter(path, columns.size(), file, kept.count);
}

Status CsvWriter::append(std::span<const double> row) {
  if (row.size() != m_columns)
    return make_error(ErrorCode::usage, "{}: a row of {} values for {} columns", m_path.string(), row.size(),
                      m_columns);
  std::string line;
  for (const double value : row)
    line += fmt::format("{}{}", line.empty() ? "" : ",", value);
  line += "\n";
  // One write per row: a reader or a kill meets whole rows, save on a full disk.
  for (std::string_view rest = line; !rest.empty();) {
    const ssize_t written = ::write(m_file, rest.data(), rest.size());
    if (written < 0 && errno == EINTR)
      continue;
    if (written < 0)
      return write_error("write", m_path, errno);
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  return {};
}

Status CsvWriter::sync() {
  while (::fsync(m_file) < 0) {
    if (errno != EINTR)
      return write_error("write", m_path, errno);
  }
  return {};
}

} // namespace wry::pipeline
