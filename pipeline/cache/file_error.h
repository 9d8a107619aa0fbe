#pragma once

#include <filesystem>
#include <string_view>

#include "sim/base/result.h"

namespace wry::pipeline {

/// The error of a failed write-side call: cannot_write for a full disk, missing rights or a vanished folder, io for the
/// rest. `doing` completes "cannot ... PATH", for example "write"; `error_number` is errno.
Error write_error(std::string_view doing, const std::filesystem::path& path, int error_number);

/// The error of a failed read-side call: missing_input when nothing is there, io for the rest.
Error read_error(const std::filesystem::path& path, int error_number);

/// "12.3 MiB"
std::string readable_bytes(std::uintmax_t bytes);

} // namespace wry::pipeline
