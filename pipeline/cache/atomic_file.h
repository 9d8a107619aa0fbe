#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "sim/base/result.h"

namespace wry::pipeline {

/// The steps of putting a file in its place, in the order in which they happen.
enum class FileStep { open, write, sync, rename, sync_folder, remove };

/// Asked before each step; an errno other than 0 makes that step fail with it. Empty in production; tests inject a full
/// disk, a vanished folder or a dying device at any step.
using FaultHook = std::function<int(FileStep, const std::filesystem::path&)>;

/// Files that end like this are unfinished: no reader takes them, and the next writer of the folder removes them.
inline constexpr std::string_view ASIDE_SUFFIX = ".aside";

/// `path` with ASIDE_SUFFIX.
std::filesystem::path aside_of(const std::filesystem::path& path);

/// Writes all bytes to `path`, every return checked, and has the disk take them (fsync). On failure nothing is left
/// there. Errors: cannot_write, io.
Status write_synced(const std::filesystem::path& path, std::string_view bytes, const FaultHook& faults = {});

/// Renames a finished file to its name and has the disk keep the renaming (fsync of the folder). Errors: cannot_write,
/// io.
Status publish(const std::filesystem::path& aside, const std::filesystem::path& path, const FaultHook& faults = {});

/// write_synced() aside, then publish(): whoever reads `path` sees all of the old bytes or all of the new, also after a
/// kill.
Status write_file_atomically(const std::filesystem::path& path, std::string_view bytes, const FaultHook& faults = {});

/// Appends bytes in one write and has the disk take them. Errors: cannot_write, io; part of the bytes may then be
/// there.
Status append_synced(const std::filesystem::path& path, std::string_view bytes, const FaultHook& faults = {});

/// Has the disk keep the names in a folder. Errors: io.
Status sync_folder(const std::filesystem::path& folder, const FaultHook& faults = {});

/// Removes a file; one that is not there is no error. Errors: cannot_write, io.
Status remove_file(const std::filesystem::path& path, const FaultHook& faults = {});

/// Everything in a file. Errors: missing_input, io; out_of_memory.
Result<std::string> read_whole_file(const std::filesystem::path& path);

/// Makes the folder with its parents and shows, by writing and removing a small file, that files can be made in it:
/// done before simulating, not after. Errors: cannot_write.
Status prepare_folder(const std::filesystem::path& folder);

/// Bytes that this user can still write on the disk of `folder`, which exists. Errors: io.
Result<std::uint64_t> free_space(const std::filesystem::path& folder);

} // namespace wry::pipeline
