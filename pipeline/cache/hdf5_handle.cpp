#include "pipeline/cache/hdf5_handle.h"

#include <atomic>
#include <cstddef>

#include <fmt/format.h>
#include <hdf5.h>

namespace wry::pipeline {

namespace {

constexpr std::size_t MEMORY_STEP = 4 << 20; ///< growth of a file in memory [bytes]

struct Failure {
  std::string words;
  bool is_of_memory = false;
};

herr_t take_entry(unsigned depth, const H5E_error2_t* entry, void* data) {
  Failure& failure = *static_cast<Failure*>(data);
  if (depth == 0 && entry->desc != nullptr)
    failure.words = entry->desc;
  if (entry->min_num == H5E_NOSPACE || entry->min_num == H5E_CANTALLOC)
    failure.is_of_memory = true;
  return 0;
}

} // namespace

Hdf5QuietErrors::Hdf5QuietErrors() {
  // A damaged file can leave HDF5 with objects that it fails to close at exit, and then it complains on stderr.
  // Everything of ours is closed by then.
  [[maybe_unused]] static const herr_t once = H5dont_atexit();
  H5Eget_auto2(H5E_DEFAULT, &m_function, &m_data);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Hdf5QuietErrors::~Hdf5QuietErrors() {
  H5Eset_auto2(H5E_DEFAULT, m_function, m_data);
}

Error hdf5_error(const std::string& what) {
  Failure failure;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_entry, &failure);
  H5Eclear2(H5E_DEFAULT);
  const ErrorCode code = failure.is_of_memory ? ErrorCode::out_of_memory : ErrorCode::io;
  return make_error(code, "{}: {}", what, failure.words.empty() ? "no reason given" : failure.words);
}

Hdf5Handle hdf5_memory_access() {
  Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_libver_bounds(access.id(), H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  H5Pset_fapl_core(access.id(), MEMORY_STEP, 0);
  return access;
}

std::string hdf5_memory_name() {
  static std::atomic<std::uint64_t> count = 0;
  return fmt::format("image-{}", ++count);
}

} // namespace wry::pipeline
