#include "render/write_file.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

namespace wry::render {
namespace {

Status write_all(int file, std::span<const std::uint8_t> bytes, const std::filesystem::path& path) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t written = ::write(file, bytes.data() + done, bytes.size() - done);
    if (written < 0 && errno == EINTR)
      continue;
    if (written <= 0)
      return make_error(ErrorCode::io, "{}: only {} of {} bytes could be written: {}", path.string(), done,
                        bytes.size(), std::strerror(errno));
    done += static_cast<std::size_t>(written);
  }
  return {};
}

} // namespace

Status write_file_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  const std::filesystem::path aside = path.string() + fmt::format(".part{}", ::getpid());
  const int file = ::open(aside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0)
    return make_error(ErrorCode::cannot_write, "{}: cannot be made: {}; check the folder and its rights",
                      aside.string(), std::strerror(errno));
  Status status = write_all(file, bytes, aside);
  if (status.ok() && ::fsync(file) != 0)
    status = make_error(ErrorCode::io, "{}: cannot be flushed to disk: {}", aside.string(), std::strerror(errno));
  if (::close(file) != 0 && status.ok())
    status = make_error(ErrorCode::io, "{}: cannot be closed: {}", aside.string(), std::strerror(errno));
  if (status.ok() && ::rename(aside.c_str(), path.c_str()) != 0)
    status = make_error(ErrorCode::cannot_write, "{}: cannot be renamed to {}: {}", aside.string(), path.string(),
                        std::strerror(errno));
  if (!status.ok())
    ::unlink(aside.c_str());
  return status;
}

} // namespace wry::render
