#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "sim/base/result.h"

namespace wry::pipeline {

/// Who holds an output folder, as its lock file says. What a system does not tell is "-".
struct LockHolder {
  std::string host;
  std::string machine;       ///< machine id
  std::string boot;          ///< boot id
  std::string pid_namespace; ///< process numbers mean something only within it
  long pid = 0;
  unsigned long long start = 0; ///< start time of the process [clock ticks since boot]
};

/// This process.
LockHolder this_process();

/// One run per output folder.
///
/// The file `lock` in the folder is held with flock() as long as the run lives, and names its holder. The kernel lets
/// go of it when the process dies, however it dies, so on one machine a stale lock never stops anyone. Where flock()
/// does not reach, on folders that several machines share, the holder also counts up in the file every few seconds, and
/// a newcomer takes over only when the count has stood still for long. No time stamps are compared.
class FolderLock {
public:
  struct Settings {
    std::chrono::milliseconds beat = std::chrono::seconds(5);      ///< how often the holder counts up
    std::chrono::milliseconds patience = std::chrono::seconds(30); ///< how long a count must stand still
  };

  /// Takes the folder, which exists. Errors: cannot_write when another run holds it (the message names the holder) or
  /// the folder is not writable; io.
  static Result<FolderLock> acquire(const std::filesystem::path& folder, const Settings& settings);
  static Result<FolderLock> acquire(const std::filesystem::path& folder) { return acquire(folder, Settings()); }

  ~FolderLock();
  FolderLock(FolderLock&&) noexcept;
  FolderLock& operator=(FolderLock&&) noexcept;

  /// Empty, or whose stale lock was taken over, for a warning.
  const std::string& recovered_from() const;

private:
  struct Held;
  explicit FolderLock(std::unique_ptr<Held> held);
  std::unique_ptr<Held> m_held;
};

} // namespace wry::pipeline
