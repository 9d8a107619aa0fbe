#include "tests/cli/children_support.h"

#include <sys/resource.h>

namespace wry::cli_test {

namespace fs = std::filesystem;

double cpu_seconds_of_children() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double peak_bytes_of_children() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  return 1024.0 * double(usage.ru_maxrss);
}

double bytes_in(const fs::path& folder) {
  double bytes = 0.0;
  for (const fs::directory_entry& file : fs::recursive_directory_iterator(folder))
    if (file.is_regular_file())
      bytes += double(file.file_size());
  return bytes;
}

} // namespace wry::cli_test
