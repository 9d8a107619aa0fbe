#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace wry::pipeline {

/// A whole table on disk, as text.
struct CsvTable {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;

  /// The numbers of a column, NaN where there is none; empty when there is no such column.
  std::vector<double> numbers(const std::string& column) const;
};

/// Reads measure.csv, stats.csv or sweep.csv. Empty when it is not there.
CsvTable read_csv_table(const std::filesystem::path& path);

/// The number that a text is, NaN when it is none.
double number_of(const std::string& text);

} // namespace wry::pipeline
