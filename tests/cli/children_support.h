#pragma once

#include <filesystem>

namespace wry::cli_test {

/// CPU time of the programs that this one started and that have ended [s].
double cpu_seconds_of_children();

/// The most memory that any of them had.
double peak_bytes_of_children();

/// Of all files in a folder.
double bytes_in(const std::filesystem::path& folder);

} // namespace wry::cli_test
