#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/cache/atomic_file.h"
#include "sim/base/result.h"

namespace wry::pipeline {

/// A table on disk that grows by whole rows and survives kills: stats.csv, measure.csv.
///
/// On opening, the rows that come after the point a run resumes from are cut off, as is a row that a kill tore, so that
/// no row stands there twice. Numbers are written with the fewest digits that read back the same bits. The caller calls
/// sync() before it writes the checkpoint that those rows belong to.
class CsvWriter {
public:
  /// Opens or makes the table. Rows whose value in `key_column` (whole numbers that never fall) is at most `last_kept`
  /// stay. A table with other columns is of another version: it is replaced. Errors: cannot_write, io; usage when
  /// `key_column` is none of `columns`.
  static Result<CsvWriter> open(const std::filesystem::path& path, std::vector<std::string> columns,
                                const std::string& key_column, std::int64_t last_kept);

  ~CsvWriter();
  CsvWriter(CsvWriter&& other) noexcept;
  CsvWriter& operator=(CsvWriter&& other) noexcept;

  /// A row of numbers, one per column; whole numbers are written without a point. Errors: cannot_write, io; usage for
  /// another count.
  Status append(std::span<const double> row);
  /// Has the disk keep the rows. Errors: cannot_write, io.
  Status sync();

  /// Rows that were kept on opening.
  std::size_t kept_rows() const { return m_kept_rows; }

private:
  CsvWriter(std::filesystem::path path, std::size_t columns, int file, std::size_t kept_rows);

  std::filesystem::path m_path;
  std::size_t m_columns = 0;
  std::size_t m_kept_rows = 0;
  int m_file = -1;
};

/// A field as CSV wants it: in quotes when it has a comma, a quote or a line break (RFC 4180).
std::string csv_field(std::string_view text);

/// The fields of one line without its line break, quotes undone.
std::vector<std::string> split_csv_line(std::string_view line);

} // namespace wry::pipeline
