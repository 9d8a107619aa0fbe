#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/result.h"

namespace wry::pipeline {

/// How the arrays of a file are packed. Deflate level 1 saves about a third of a frame, at a tenth of the speed.
enum class Compression { none, deflate };

/// The element type of an array in a file.
enum class ArrayType { float32, float64, int32 };

/// Builds an HDF5 file in memory: the latest format, every array chunked with fletcher32 and NaN as fill value, members
/// in the order in which they were made. Nothing touches a disk, so every byte can go through checked writes of our
/// own.
///
/// The first error is kept and returned by finish(); calls after it do nothing.
class Hdf5ImageWriter {
public:
  explicit Hdf5ImageWriter(Compression compression);
  ~Hdf5ImageWriter();
  Hdf5ImageWriter(const Hdf5ImageWriter&) = delete;
  Hdf5ImageWriter& operator=(const Hdf5ImageWriter&) = delete;

  /// Paths are absolute ("/bodies/0000"); "/" is there from the start, parents must be made first.
  void group(const std::string& path);
  void attribute(const std::string& path, const std::string& name, const std::string& text);
  void attribute(const std::string& path, const std::string& name, double number);
  void attribute(const std::string& path, const std::string& name, std::int64_t number);
  /// `values` are row-major, product(shape) of them. As float32 a finite value out of its range is an error (io).
  void array(const std::string& path, const std::vector<std::size_t>& shape, std::span<const double> values,
             ArrayType type);
  void array(const std::string& path, const std::vector<std::size_t>& shape, std::span<const std::int32_t> values);

  /// The bytes of the file. Errors: io, out_of_memory, naming the object that failed.
  Result<std::string> finish();

private:
  struct File;
  std::unique_ptr<File> m_file;
};

/// What an array of a file looks like.
struct ArrayFacts {
  std::vector<std::size_t> shape;
  ArrayType type = ArrayType::float64;
};

/// Reads an HDF5 file that is in memory. Every read checks fletcher32.
///
/// The first error is kept, naming the file and the object; reads after it return nothing. Look at status() before
/// using what was read.
class Hdf5ImageReader {
public:
  /// `name` is the file's, for messages.
  Hdf5ImageReader(std::string bytes, std::string name);
  ~Hdf5ImageReader();
  Hdf5ImageReader(const Hdf5ImageReader&) = delete;
  Hdf5ImageReader& operator=(const Hdf5ImageReader&) = delete;

  /// Names of a group's members in the order in which they were made.
  std::vector<std::string> members(const std::string& path);
  std::string text(const std::string& path, const std::string& name);
  double number(const std::string& path, const std::string& name);
  std::int64_t integer(const std::string& path, const std::string& name);
  ArrayFacts facts(const std::string& path);
  std::vector<double> doubles(const std::string& path);
  std::vector<std::int32_t> integers(const std::string& path);

  /// Records that `path` is not what this version writes, for example "has not 3 columns".
  void refuse(const std::string& path, std::string_view what);

  /// Reads every array once, to see that each check sum fits.
  void read_everything();

  /// Errors: io for a damaged or foreign file, out_of_memory.
  Status status() const;

private:
  struct File;
  std::unique_ptr<File> m_file;
};

} // namespace wry::pipeline
