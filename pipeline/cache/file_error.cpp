#include "pipeline/cache/file_error.h"

#include <array>
#include <cerrno>
#include <system_error>

namespace wry::pipeline {

namespace {

std::string_view advice(int error_number) {
  switch (error_number) {
  case ENOSPC:
  case EDQUOT:
    return "; make space and run the same command again, it goes on from the last good frame";
  case EFBIG:
    return "; raise the limit on the size of files (ulimit -f) and run the same command again";
  case EACCES:
  case EPERM:
  case EROFS:
    return "; choose a folder you may write to with --out, or change its rights";
  case ENOENT:
  case ENOTDIR:
    return "; the folder is not there (any more): was it moved, deleted or unmounted?";
  default:
    return "";
  }
}

bool is_for_the_user_to_mend(int error_number) {
  switch (error_number) {
  case ENOSPC:
  case EDQUOT:
  case EFBIG:
  case EACCES:
  case EPERM:
  case EROFS:
  case ENOENT:
  case ENOTDIR:
  case EISDIR:
  case ENAMETOOLONG:
    return true;
  default:
    return false;
  }
}

std::string free_space_near(const std::filesystem::path& path) {
  std::error_code failed;
  const std::filesystem::space_info space = std::filesystem::space(path.parent_path(), failed);
  return failed ? std::string() : fmt::format(" ({} free)", readable_bytes(space.available));
}

} // namespace

Error write_error(std::string_view doing, const std::filesystem::path& path, int error_number) {
  const ErrorCode code = is_for_the_user_to_mend(error_number) ? ErrorCode::cannot_write : ErrorCode::io;
  const std::string space = error_number == ENOSPC ? free_space_near(path) : std::string();
  return make_error(code, "cannot {} {}: {}{}{}", doing, path.string(), std::generic_category().message(error_number),
                    space, advice(error_number));
}

Error read_error(const std::filesystem::path& path, int error_number) {
  const ErrorCode code = error_number == ENOENT ? ErrorCode::missing_input : ErrorCode::io;
  return make_error(code, "cannot read {}: {}", path.string(), std::generic_category().message(error_number));
}

std::string readable_bytes(std::uintmax_t bytes) {
  constexpr std::array<std::string_view, 5> UNITS = {"B", "KiB", "MiB", "GiB", "TiB"};
  double amount = static_cast<double>(bytes);
  std::size_t unit = 0;
  while (amount >= 1024.0 && unit + 1 < UNITS.size()) {
    amount /= 1024.0;
    ++unit;
  }
  return unit == 0 ? fmt::format("{} B", bytes) : fmt::format("{:.1f} {}", amount, UNITS[unit]);
}

} // namespace wry::pipeline
