#include "pipeline/cache/hdf5_image.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <utility>

#include <hdf5.h>

#include "pipeline/cache/hdf5_handle.h"

namespace wry::pipeline {

namespace {

using Handle = Hdf5Handle;

constexpr std::size_t CHUNK_BYTES = 1 << 20; ///< about this much of an array per check sum

Handle property_list(hid_t kind) {
  return Handle(H5Pcreate(kind), H5Pclose);
}

/// Creation properties of a group or an array: no time stamps, so that the same frame is the same bytes.
Handle object_properties(hid_t kind) {
  Handle creation = property_list(kind);
  H5Pset_obj_track_times(creation.id(), false);
  return creation;
}

/// The memory of an image after its file was closed. (H5Fget_file_image on the open file gives one of HDF5 1.10.8's
/// latest format a head whose check sum is wrong.)
class ClosedImage {
public:
  ClosedImage() = default;
  ~ClosedImage() { std::free(m_memory); }
  ClosedImage(const ClosedImage&) = delete;
  ClosedImage& operator=(const ClosedImage&) = delete;

  /// Up to the end of the file that its superblock (version 3) names; empty if that is not within the memory.
  std::string_view bytes() const {
    constexpr std::size_t SUPERBLOCK_BYTES = 48;
    constexpr std::size_t END_OF_FILE_AT = 28;
    std::uint64_t end = 0;
    if (m_memory == nullptr || m_size < SUPERBLOCK_BYTES)
      return {};
    std::memcpy(&end, m_memory + END_OF_FILE_AT, sizeof(end));
    return end <= m_size ? std::string_view(m_memory, end) : std::string_view();
  }

  void* resize(void* memory, std::size_t size) {
    char* resized = static_cast<char*>(std::realloc(memory, size));
    if (resized == nullptr)
      return nullptr;
    // HDF5 leaves gaps; with zeros in them the same frame is the same bytes.
    const std::size_t old_size = memory == nullptr ? 0 : m_size;
    if (size > old_size)
      std::memset(resized + old_size, 0, size - old_size);
    m_size = size;
    return resized;
  }
  void keep(void* memory) { m_memory = static_cast<char*>(memory); }

private:
  char* m_memory = nullptr;
  std::size_t m_size = 0; ///< of the only block that HDF5 has of us
};

void* resize_image(void* memory, size_t size, H5FD_file_image_op_t, void* image) {
  return static_cast<ClosedImage*>(image)->resize(memory, size);
}

void* make_image(size_t size, H5FD_file_image_op_t, void* image) {
  return static_cast<ClosedImage*>(image)->resize(nullptr, size);
}

herr_t keep_image(void* memory, H5FD_file_image_op_t, void* image) {
  static_cast<ClosedImage*>(image)->keep(memory);
  return 0;
}

void keep_image_at_close(hid_t access, ClosedImage& image) {
  H5FD_file_image_callbacks_t callbacks{};
  callbacks.image_malloc = make_image;
  callbacks.image_realloc = resize_image;
  callbacks.image_free = keep_image;
  callbacks.udata_copy = [](void* same) { return same; };
  callbacks.udata_free = [](void*) -> herr_t { return 0; };
  callbacks.udata = &image;
  H5Pset_file_image_callbacks(access, &callbacks);
}

hid_t stored_type(ArrayType type) {
  switch (type) {
  case ArrayType::float32:
    return H5T_IEEE_F32LE;
  case ArrayType::float64:
    return H5T_IEEE_F64LE;
  case ArrayType::int32:
    return H5T_STD_I32LE;
  }
  return H5I_INVALID_HID;
}

std::size_t bytes_of(ArrayType type) {
  return type == ArrayType::float64 ? 8 : 4;
}

/// Rows per chunk so that chunks have CHUNK_BYTES or a little less; all of a small array. Chunks are alike, since the
/// last one takes as much of the file as the others however few rows it has.
std::vector<hsize_t> chunk_of(const std::vector<hsize_t>& shape, std::size_t element_bytes) {
  std::vector<hsize_t> chunk = shape;
  hsize_t row_bytes = element_bytes;
  for (std::size_t i = 1; i < shape.size(); ++i)
    row_bytes *= shape[i];
  const hsize_t most_rows = std::max<hsize_t>(CHUNK_BYTES / row_bytes, 1);
  const hsize_t chunks = (shape[0] + most_rows - 1) / most_rows;
  chunk[0] = (shape[0] + chunks - 1) / chunks;
  return chunk;
}

std::size_t count_of(const std::vector<std::size_t>& shape) {
  std::size_t count = 1;
  for (const std::size_t extent : shape)
    count *= extent;
  return count;
}

} // namespace

struct Hdf5ImageWriter::File {
  std::unique_ptr<ClosedImage> image = std::make_unique<ClosedImage>();
  Hdf5QuietErrors quiet;
  Handle file{H5I_INVALID_HID, H5Fclose};
  Compression compression = Compression::none;
  std::optional<Error> error;

  void fail(const std::string& what) {
    Error failure = hdf5_error(fmt::format("cannot put {} into an HDF5 file", what));
    if (!error)
      error = std::move(failure);
  }

  Handle creation_properties(const std::vector<hsize_t>& shape, ArrayType type) const;
  void array(const std::string& path, const std::vector<std::size_t>& shape, const void* values, ArrayType type,
             hid_t memory_type);
  void attribute(const std::string& path, const std::string& name, hid_t type, hid_t memory_type, const void* value);
};

Hdf5ImageWriter::Hdf5ImageWriter(Compression compression)
    : m_file(std::make_unique<File>()) {
  const Handle creation = object_properties(H5P_FILE_CREATE);
  const Handle access = hdf5_memory_access();
  keep_image_at_close(access.id(), *m_file->image);
  H5Pset_link_creation_order(creation.id(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  m_file->compression = compression;
  m_file->file = Handle(H5Fcreate(hdf5_memory_name().c_str(), H5F_ACC_TRUNC, creation.id(), access.id()), H5Fclose);
  if (!m_file->file.ok())
    m_file->fail("the root group");
}

Hdf5ImageWriter::~Hdf5ImageWriter() = default;

void Hdf5ImageWriter::group(const std::string& path) {
  if (m_file->error)
    return;
  const Handle creation = object_properties(H5P_GROUP_CREATE);
  H5Pset_link_creation_order(creation.id(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  Handle made(H5Gcreate2(m_file->file.id(), path.c_str(), H5P_DEFAULT, creation.id(), H5P_DEFAULT), H5Gclose);
  if (!made.ok() || !made.close())
    m_file->fail(path);
}

void Hdf5ImageWriter::File::attribute(const std::string& path, const std::string& name, hid_t type, hid_t memory_type,
                                      const void* value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  Handle made(
      H5Acreate_by_name(file.id(), path.c_str(), name.c_str(), type, space.id(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose);
  if (!made.ok() || H5Awrite(made.id(), memory_type, value) < 0 || !made.close())
    fail(fmt::format("{}, attribute {}", path, name));
}

void Hdf5ImageWriter::attribute(const std::string& path, const std::string& name, const std::string& text) {
  if (m_file->error)
    return;
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.id(), text.size() + 1);
  H5Tset_cset(type.id(), H5T_CSET_UTF8);
  m_file->attribute(path, name, type.id(), type.id(), text.c_str());
}

void Hdf5ImageWriter::attribute(const std::string& path, const std::string& name, double number) {
  if (m_file->error)
    return;
  m_file->attribute(path, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &number);
}

void Hdf5ImageWriter::attribute(const std::string& path, const std::string& name, std::int64_t number) {
  if (m_file->error)
    return;
  m_file->attribute(path, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &number);
}

Handle Hdf5ImageWriter::File::creation_properties(const std::vector<hsize_t>& shape, ArrayType type) const {
  Handle creation = object_properties(H5P_DATASET_CREATE);
  if (type != ArrayType::int32) {
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    H5Pset_fill_value(creation.id(), H5T_NATIVE_DOUBLE, &nothing);
  }
  const bool is_empty = std::find(shape.begin(), shape.end(), hsize_t(0)) != shape.end();
  if (is_empty || shape.empty())
    return creation;
  const std::vector<hsize_t> chunk = chunk_of(shape, bytes_of(type));
  H5Pset_chunk(creation.id(), static_cast<int>(chunk.size()), chunk.data());
  if (compression == Compression::deflate)
    H5Pset_deflate(creation.id(), 1);
  H5Pset_fletcher32(creation.id());
  return creation;
}

void Hdf5ImageWriter::File::array(const std::string& path, const std::vector<std::size_t>& shape, const void* values,
                                  ArrayType type, hid_t memory_type) {
  const std::vector<hsize_t> extents(shape.begin(), shape.end());
  const Handle space(H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr), H5Sclose);
  const Handle creation = creation_properties(extents, type);
  Handle made(
      H5Dcreate2(file.id(), path.c_str(), stored_type(type), space.id(), H5P_DEFAULT, creation.id(), H5P_DEFAULT),
      H5Dclose);
  if (!made.ok() || H5Dwrite(made.id(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0 || !made.close())
    fail(path);
}

void Hdf5ImageWriter::array(const std::string& path, const std::vector<std::size_t>& shape,
                            std::span<const double> values, ArrayType type) {
  if (m_file->error)
    return;
  if (count_of(shape) != values.size()) {
    m_file->error =
        make_error(ErrorCode::io, "{}: its shape asks for {} values, it has {}", path, count_of(shape), values.size());
    return;
  }
  if (type == ArrayType::float64) {
    m_file->array(path, shape, values.data(), type, H5T_NATIVE_DOUBLE);
    return;
  }
  std::vector<float> narrowed(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    narrowed[i] = static_cast<float>(values[i]);
    if (std::isinf(narrowed[i]) && std::isfinite(values[i])) {
      m_file->error = make_error(
          ErrorCode::io, "{}: value {} at {} does not fit a float32; store the channel as float64", path, values[i], i);
      return;
    }
  }
  m_file->array(path, shape, narrowed.data(), type, H5T_NATIVE_FLOAT);
}

void Hdf5ImageWriter::array(const std::string& path, const std::vector<std::size_t>& shape,
                            std::span<const std::int32_t> values) {
  if (m_file->error)
    return;
  if (count_of(shape) != values.size())
    m_file->error =
        make_error(ErrorCode::io, "{}: its shape asks for {} values, it has {}", path, count_of(shape), values.size());
  else
    m_file->array(path, shape, values.data(), ArrayType::int32, H5T_NATIVE_INT32);
}

Result<std::string> Hdf5ImageWriter::finish() {
  if (!m_file->error && !m_file->file.close())
    m_file->fail("everything");
  if (m_file->error)
    return *m_file->error;
  const std::string_view bytes = m_file->image->bytes();
  if (bytes.empty())
    return make_error(ErrorCode::io, "cannot make an HDF5 file in memory: its head does not say where it ends");
  return std::string(bytes);
}

} // namespace wry::pipeline
