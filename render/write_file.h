#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "sim/base/result.h"

namespace wry::render {

/// Writes the bytes aside, flushes them to disk and renames them to `path`: a reader sees the old file, or the whole
/// new one, never a part. Errors: cannot_write (the folder or the file cannot be made), io (disk full, failed flush).
Status write_file_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

} // namespace wry::render
