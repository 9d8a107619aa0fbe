#include "pipeline/run/machine.h"

#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <system_error>

#include <unistd.h>

#include "pipeline/cache/atomic_file.h"

namespace wry::pipeline {

namespace {

namespace fs = std::filesystem;

/// A number in a file of its own, as the kernel writes them; nothing for "max" or where there is no such file.
std::optional<std::uint64_t> number_in(const fs::path& path) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  return file >> number ? std::optional<std::uint64_t>(number) : std::nullopt;
}

/// The first number behind a word, of files with a word and its numbers per line.
std::optional<std::uint64_t> number_behind(const fs::path& path, const std::string& word) {
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line)) {
    if (!line.starts_with(word))
      continue;
    std::istringstream rest(line.substr(word.size()));
    std::uint64_t number = 0;
    return rest >> number ? std::optional<std::uint64_t>(number) : std::nullopt;
  }
  return std::nullopt;
}

/// Address space and resident memory of this process [B].
struct OwnMemory {
  std::uint64_t address_space = 0, resident = 0;
};

OwnMemory own_memory(const fs::path& processes) {
  std::ifstream file(processes / "self" / "statm");
  std::uint64_t pages = 0, resident = 0;
  file >> pages >> resident;
  const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  return {pages * page, resident * page};
}

/// What is left under a limit, and what this process has already.
std::uint64_t room_under(std::uint64_t limit, std::uint64_t used, std::uint64_t own) {
  return (limit > used ? limit - used : 0) + own;
}

/// A control group's files, which the two versions name differently.
struct GroupFiles {
  const char* limit;
  const char* used;
  const char* reclaimable; ///< in memory.stat: file pages that the kernel gives back before it refuses
};
constexpr GroupFiles VERSION_1 = {"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file "};
constexpr GroupFiles VERSION_2 = {"memory.max", "memory.current", "inactive_file "};
// Version 1 says "no limit" with the largest number of whole pages.
constexpr std::uint64_t NO_LIMIT = std::numeric_limits<std::int64_t>::max() / 2;

/// The limit of a group and of all above it. In a container the group's own path may lie outside of what is mounted.
void add_groups(const fs::path& root, fs::path group, const GroupFiles& names, std::uint64_t own,
                std::vector<Room>& rooms) {
  for (;; group = group.parent_path()) {
    const fs::path folder = root / group.relative_path();
    const std::optional<std::uint64_t> limit = number_in(folder / names.limit);
    if (limit && *limit < NO_LIMIT) {
      const std::uint64_t used = number_in(folder / names.used).value_or(0);
      const std::uint64_t reclaimable = number_behind(folder / "memory.stat", names.reclaimable).value_or(0);
      rooms.push_back({room_under(*limit, used > reclaimable ? used - reclaimable : 0, own),
                       "the control group's memory (" + (folder / names.limit).string() + ")"});
    }
    if (group.relative_path().empty())
      return;
  }
}

/// Lines of /proc/self/cgroup: "0::/path" of version 2, "4:memory:/path" of version 1.
void add_all_groups(const SystemFiles& files, std::uint64_t own, std::vector<Room>& rooms) {
  std::ifstream list(files.processes / "self" / "cgroup");
  std::string line;
  while (std::getline(list, line)) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos)
      continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const fs::path group = line.substr(second + 1);
    if (controllers == ",,")
      add_groups(files.control_groups, group, VERSION_2, own, rooms);
    else if (controllers.find(",memory,") != std::string::npos)
      add_groups(files.control_groups / "memory", group, VERSION_1, own, rooms);
  }
}

std::uint64_t bytes_below(const fs::path& folder) {
  std::uint64_t bytes = 0;
  std::error_code failed;
  for (fs::recursive_directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed)) {
    const std::uint64_t size = entry->is_regular_file(failed) ? entry->file_size(failed) : 0;
    if (!failed)
      bytes += size;
  }
  return bytes;
}

} // namespace

Result<Machine> read_machine(const fs::path& folder, const SystemFiles& files) {
  Machine machine;
  const OwnMemory own = own_memory(files.processes);
  if (const auto kibibytes = number_behind(files.processes / "meminfo", "MemAvailable:"))
    machine.memory.push_back({*kibibytes * 1024 + own.resident, "this machine's memory"});
  add_all_groups(files, own.resident, machine.memory);
  // "Max address space   4194304000   unlimited   bytes"; soft limit first.
  if (const auto limit = number_behind(files.processes / "self" / "limits", "Max address space"))
    machine.memory.push_back({room_under(*limit, own.address_space, own.resident), "the address space (ulimit -v)"});
  const Result<std::uint64_t> space = free_space(folder);
  if (!space)
    return space.error();
  std::uint64_t left_there = 0;
  for (const char* part : {"frames", "checkpoints", "fields"})
    left_there += bytes_below(folder / part);
  machine.disk.push_back({*space + left_there, "the disk of " + folder.string()});
  return machine;
}

} // namespace wry::pipeline
