#include "pipeline/cache/atomic_file.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>
#include <utility>

#include "pipeline/cache/file_error.h"
#include "pipeline/cache/memory_guard.h"

namespace wry::pipeline {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t WRITE_PIECE = 4 << 20;

class Descriptor {
public:
  explicit Descriptor(int number)
      : m_number(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return m_number; }
  int close() { return m_number < 0 ? 0 : ::close(std::exchange(m_number, -1)); }

private:
  int m_number;
};

/// 0, or the errno that a hook or the failing call gave.
template <class Call> int step(const FaultHook& faults, FileStep kind, const fs::path& path, const Call& call) {
  if (faults) {
    if (const int injected = faults(kind, path); injected != 0)
      return injected;
  }
  while (call() < 0) {
    if (errno != EINTR)
      return errno;
  }
  return 0;
}

int write_all(int file, std::string_view bytes, const fs::path& path, const FaultHook& faults) {
  while (!bytes.empty()) {
    ssize_t written = 0;
    const std::size_t piece = std::min(bytes.size(), WRITE_PIECE);
    const auto call = [&] { return written = ::write(file, bytes.data(), piece); };
    if (const int failure = step(faults, FileStep::write, path, call); failure != 0)
      return failure;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

Status write_and_sync(const fs::path& path, std::string_view bytes, int flags, const FaultHook& faults) {
  int number = -1;
  const auto open = [&] { return number = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | flags, 0666); };
  if (const int failure = step(faults, FileStep::open, path, open); failure != 0)
    return write_error("write", path, failure);
  Descriptor file(number);
  if (const int failure = write_all(number, bytes, path, faults); failure != 0)
    return write_error("write", path, failure);
  if (const int failure = step(faults, FileStep::sync, path, [&] { return ::fsync(number); }); failure != 0)
    return write_error("write", path, failure);
  // NFS reports a full disk only here; EINTR from close leaves the descriptor closed on Linux.
  if (file.close() < 0 && errno != EINTR)
    return write_error("write", path, errno);
  return {};
}

Result<std::string> read_all(const fs::path& path) {
  Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat facts {};
  if (file.number() < 0 || ::fstat(file.number(), &facts) < 0)
    return read_error(path, errno);
  if (!S_ISREG(facts.st_mode))
    return make_error(ErrorCode::io, "cannot read {}: it is not a file", path.string());
  std::string bytes(static_cast<std::size_t>(facts.st_size), '\0');
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t count = ::read(file.number(), bytes.data() + filled, bytes.size() - filled);
    if (count < 0 && errno == EINTR)
      continue;
    if (count < 0)
      return read_error(path, errno);
    if (count == 0)
      break;
    filled += static_cast<std::size_t>(count);
  }
  bytes.resize(filled);
  return bytes;
}

} // namespace

fs::path aside_of(const fs::path& path) {
  fs::path aside = path;
  aside += ASIDE_SUFFIX;
  return aside;
}

Status write_synced(const fs::path& path, std::string_view bytes, const FaultHook& faults) {
  Status written = write_and_sync(path, bytes, O_TRUNC, faults);
  if (!written)
    ::unlink(path.c_str());
  return written;
}

Status sync_folder(const fs::path& folder, const FaultHook& faults) {
  const fs::path name = folder.empty() ? fs::path(".") : folder;
  Descriptor file(::open(name.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (file.number() < 0)
    return write_error("keep names in", name, errno);
  const auto sync = [&] { return ::fsync(file.number()); };
  const int failure = step(faults, FileStep::sync_folder, name, sync);
  // Some network file systems cannot sync a folder and say so; their server does it by itself.
  if (failure != 0 && failure != EINVAL)
    return write_error("keep names in", name, failure);
  return {};
}

Status publish(const fs::path& aside, const fs::path& path, const FaultHook& faults) {
  const auto rename = [&] { return ::rename(aside.c_str(), path.c_str()); };
  if (const int failure = step(faults, FileStep::rename, path, rename); failure != 0) {
    ::unlink(aside.c_str());
    return write_error("put in place", path, failure);
  }
  return sync_folder(path.parent_path(), faults);
}

Status write_file_atomically(const fs::path& path, std::string_view bytes, const FaultHook& faults) {
  const fs::path aside = aside_of(path);
  if (Status written = write_synced(aside, bytes, faults); !written)
    return written;
  return publish(aside, path, faults);
}

Status append_synced(const fs::path& path, std::string_view bytes, const FaultHook& faults) {
  return write_and_sync(path, bytes, O_APPEND, faults);
}

Status remove_file(const fs::path& path, const FaultHook& faults) {
  const auto remove = [&] { return ::unlink(path.c_str()); };
  const int failure = step(faults, FileStep::remove, path, remove);
  if (failure != 0 && failure != ENOENT)
    return write_error("remove", path, failure);
  return {};
}

Result<std::string> read_whole_file(const fs::path& path) {
  return or_out_of_memory(path.string(), [&] { return read_all(path); });
}

Status prepare_folder(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed)
    return write_error("make the folder", folder, failed.value());
  const fs::path probe = folder / fmt::format("probe.{}{}", ::getpid(), ASIDE_SUFFIX);
  if (Status written = write_synced(probe, "wry was here\n"); !written)
    return Error{ErrorCode::cannot_write, written.error().message};
  return remove_file(probe);
}

Result<std::uint64_t> free_space(const fs::path& folder) {
  struct statvfs facts {};
  if (::statvfs(folder.c_str(), &facts) < 0)
    return read_error(folder, errno);
  return static_cast<std::uint64_t>(facts.f_bavail) * facts.f_frsize;
}

} // namespace wry::pipeline
