#include "pipeline/report/csv_table.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/report/csv.h"

namespace wry::pipeline {

namespace {

/// Where a record ends: at a line break outside of quotes.
std::size_t end_of_record(const std::string& text, std::size_t begin) {
  bool quoted = false;
  for (std::size_t at = begin; at < text.size(); ++at) {
    if (text[at] == '"')
      quoted = !quoted;
    else if (text[at] == '\n' && !quoted)
      return at;
  }
  return text.size();
}

} // namespace

std::vector<double> CsvTable::numbers(const std::string& column) const {
  const auto place = std::find(columns.begin(), columns.end(), column);
  std::vector<double> values;
  if (place == columns.end())
    return values;
  const auto index = static_cast<std::size_t>(place - columns.begin());
  for (const std::vector<std::string>& row : rows)
    values.push_back(index < row.size() ? number_of(row[index]) : std::numeric_limits<double>::quiet_NaN());
  return values;
}

CsvTable read_csv_table(const std::filesystem::path& path) {
  CsvTable table;
  const Result<std::string> text = read_whole_file(path);
  if (!text)
    return table;
  std::size_t begin = 0;
  while (begin < text->size()) {
    const std::size_t end = end_of_record(*text, begin);
    std::vector<std::string> fields = split_csv_line(std::string_view(*text).substr(begin, end - begin));
    if (table.columns.empty())
      table.columns = std::move(fields);
    else
      table.rows.push_back(std::move(fields));
    begin = end + 1;
  }
  return table;
}

double number_of(const std::string& text) {
  double number = 0.0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && stop == end ? number : std::numeric_limits<double>::quiet_NaN();
}

} // namespace wry::pipeline
