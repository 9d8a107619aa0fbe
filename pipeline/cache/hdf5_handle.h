#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "sim/base/result.h"

namespace wry::pipeline {

/// An HDF5 identifier (hid_t) that closes itself. For the files that speak to HDF5 only.
class Hdf5Handle {
public:
  using Closer = int (*)(std::int64_t);
  Hdf5Handle(std::int64_t id, Closer closer)
      : m_id(id)
      , m_close(closer) {}
  ~Hdf5Handle() { close(); }
  Hdf5Handle(Hdf5Handle&& other) noexcept
      : m_id(std::exchange(other.m_id, -1))
      , m_close(other.m_close) {}
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    close();
    m_id = std::exchange(other.m_id, -1);
    m_close = other.m_close;
    return *this;
  }

  bool ok() const { return m_id >= 0; }
  std::int64_t id() const { return m_id; }
  /// Whether closing worked; with HDF5 this is where some failures of writing show.
  bool close() { return m_id < 0 || m_close(std::exchange(m_id, -1)) >= 0; }

private:
  std::int64_t m_id;
  Closer m_close;
};

/// HDF5 prints its error stack to stderr unless told otherwise, per thread. While one of these lives it is silent.
class Hdf5QuietErrors {
public:
  Hdf5QuietErrors();
  ~Hdf5QuietErrors();
  Hdf5QuietErrors(const Hdf5QuietErrors&) = delete;
  Hdf5QuietErrors& operator=(const Hdf5QuietErrors&) = delete;

private:
  int (*m_function)(std::int64_t, void*) = nullptr;
  void* m_data = nullptr;
};

/// HDF5's last failure on this thread as an error of ours: `what` followed by its innermost message; clears it. The
/// code is out_of_memory when an allocation failed, else io.
Error hdf5_error(const std::string& what);

/// File access of images in memory: the latest format, the core driver without a file behind it.
Hdf5Handle hdf5_memory_access();

/// A name that no other image in memory has: HDF5 takes two of the same name for one file.
std::string hdf5_memory_name();

} // namespace wry::pipeline
