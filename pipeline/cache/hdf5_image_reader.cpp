#include <algorithm>
#include <limits>
#include <type_traits>
#include <utility>

#include <hdf5.h>

#include "pipeline/cache/hdf5_handle.h"
#include "pipeline/cache/hdf5_image.h"

namespace wry::pipeline {

namespace {

using Handle = Hdf5Handle;

constexpr int MOST_DIMENSIONS = 8;
constexpr std::size_t MOST_TEXT = 1 << 20;
constexpr std::size_t MOST_VALUES = 1ull << 36; ///< no array of ours has more; a damaged shape may say so

std::optional<ArrayType> array_type(hid_t type) {
  if (H5Tequal(type, H5T_IEEE_F32LE) > 0)
    return ArrayType::float32;
  if (H5Tequal(type, H5T_IEEE_F64LE) > 0)
    return ArrayType::float64;
  if (H5Tequal(type, H5T_STD_I32LE) > 0)
    return ArrayType::int32;
  return std::nullopt;
}

herr_t take_name(hid_t, const char* member, const H5L_info_t*, void* list) {
  static_cast<std::vector<std::string>*>(list)->emplace_back(member);
  return 0;
}

std::string attribute_path(const std::string& path, const std::string& name) {
  return fmt::format("{}, attribute {}", path, name);
}

} // namespace

struct Hdf5ImageReader::File {
  std::string name;
  std::optional<Error> error;
  Hdf5QuietErrors quiet;
  Handle file{H5I_INVALID_HID, H5Fclose};

  void damaged(const std::string& what) {
    Error failure = hdf5_error(fmt::format("{} is damaged at {}", name, what));
    if (!error && failure.code == ErrorCode::out_of_memory)
      out_of_memory(what);
    else if (!error)
      error = std::move(failure);
  }
  void out_of_memory(std::string_view what) {
    if (!error)
      error = make_error(ErrorCode::out_of_memory, "not enough memory for {} of {}", what, name);
  }
  void refuse(const std::string& path, std::string_view what) {
    if (!error)
      error = make_error(ErrorCode::io, "{} is damaged or not ours: {} {}", name, path, what);
  }

  ArrayFacts facts(const std::string& path, hid_t array);
  template <class T> std::vector<T> values(const std::string& path, hid_t memory_type);
  void attribute(const std::string& path, const std::string& attribute_name, hid_t memory_type, void* value);
};

Hdf5ImageReader::Hdf5ImageReader(std::string bytes, std::string name)
    : m_file(std::make_unique<File>()) {
  m_file->name = std::move(name);
  const Handle access = hdf5_memory_access();
  if (bytes.empty()) {
    m_file->refuse("/", "is empty");
    return;
  }
  if (H5Pset_file_image(access.id(), bytes.data(), bytes.size()) < 0) {
    m_file->out_of_memory("the bytes");
    return;
  }
  m_file->file = Handle(H5Fopen(hdf5_memory_name().c_str(), H5F_ACC_RDONLY, access.id()), H5Fclose);
  if (!m_file->file.ok())
    m_file->damaged("its head");
}

Hdf5ImageReader::~Hdf5ImageReader() = default;

Status Hdf5ImageReader::status() const {
  return m_file->error ? Status(*m_file->error) : Status();
}

void Hdf5ImageReader::refuse(const std::string& path, std::string_view what) {
  m_file->refuse(path, what);
}

std::vector<std::string> Hdf5ImageReader::members(const std::string& path) {
  std::vector<std::string> names;
  if (m_file->error)
    return names;
  if (H5Literate_by_name(m_file->file.id(), path.c_str(), H5_INDEX_CRT_ORDER, H5_ITER_INC, nullptr, take_name, &names,
                         H5P_DEFAULT) < 0)
    m_file->damaged(path);
  return names;
}

void Hdf5ImageReader::File::attribute(const std::string& path, const std::string& attribute_name, hid_t memory_type,
                                      void* value) {
  const Handle attribute(H5Aopen_by_name(file.id(), path.c_str(), attribute_name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  const Handle space(H5Aget_space(attribute.id()), H5Sclose);
  if (!attribute.ok() || H5Sget_simple_extent_npoints(space.id()) != 1 ||
      H5Aread(attribute.id(), memory_type, value) < 0)
    damaged(attribute_path(path, attribute_name));
}

std::string Hdf5ImageReader::text(const std::string& path, const std::string& name) {
  if (m_file->error)
    return {};
  const Handle attribute(H5Aopen_by_name(m_file->file.id(), path.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  const Handle stored(H5Aget_type(attribute.id()), H5Tclose);
  const std::size_t size = H5Tget_size(stored.id());
  if (!attribute.ok() || H5Tget_class(stored.id()) != H5T_STRING || H5Tis_variable_str(stored.id()) != 0 || size == 0 ||
      size > MOST_TEXT) {
    m_file->damaged(attribute_path(path, name));
    return {};
  }
  std::string text(size, '\0');
  m_file->attribute(path, name, stored.id(), text.data());
  text.resize(std::min(text.find('\0'), size));
  return text;
}

double Hdf5ImageReader::number(const std::string& path, const std::string& name) {
  double value = std::numeric_limits<double>::quiet_NaN();
  if (!m_file->error)
    m_file->attribute(path, name, H5T_NATIVE_DOUBLE, &value);
  return value;
}

std::int64_t Hdf5ImageReader::integer(const std::string& path, const std::string& name) {
  std::int64_t value = 0;
  if (!m_file->error)
    m_file->attribute(path, name, H5T_NATIVE_INT64, &value);
  return value;
}

ArrayFacts Hdf5ImageReader::File::facts(const std::string& path, hid_t array) {
  const Handle space(H5Dget_space(array), H5Sclose);
  const Handle stored(H5Dget_type(array), H5Tclose);
  const int dimensions = H5Sget_simple_extent_ndims(space.id());
  std::vector<hsize_t> extents(static_cast<std::size_t>(std::clamp(dimensions, 0, MOST_DIMENSIONS)));
  const std::optional<ArrayType> type = array_type(stored.id());
  if (!type || dimensions < 0 || dimensions > MOST_DIMENSIONS ||
      H5Sget_simple_extent_dims(space.id(), extents.data(), nullptr) != dimensions) {
    damaged(path);
    return {};
  }
  std::size_t count = 1;
  for (const hsize_t extent : extents) {
    if (extent != 0 && count > MOST_VALUES / extent) {
      refuse(path, "is larger than any array of ours");
      return {};
    }
    count *= extent;
  }
  return ArrayFacts{std::vector<std::size_t>(extents.begin(), extents.end()), *type};
}

ArrayFacts Hdf5ImageReader::facts(const std::string& path) {
  if (m_file->error)
    return {};
  const Handle array(H5Dopen2(m_file->file.id(), path.c_str(), H5P_DEFAULT), H5Dclose);
  return m_file->facts(path, array.id());
}

template <class T> std::vector<T> Hdf5ImageReader::File::values(const std::string& path, hid_t memory_type) {
  if (error)
    return {};
  const Handle array(H5Dopen2(file.id(), path.c_str(), H5P_DEFAULT), H5Dclose);
  const ArrayFacts known = facts(path, array.id());
  if (!error && (known.type == ArrayType::int32) != std::is_same_v<T, std::int32_t>)
    refuse(path, "has another element type");
  if (error)
    return {};
  std::size_t count = 1;
  for (const std::size_t extent : known.shape)
    count *= extent;
  std::vector<T> values(count);
  if (count != 0 && H5Dread(array.id(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    damaged(path);
  return values;
}

std::vector<double> Hdf5ImageReader::doubles(const std::string& path) {
  return m_file->values<double>(path, H5T_NATIVE_DOUBLE);
}

std::vector<std::int32_t> Hdf5ImageReader::integers(const std::string& path) {
  return m_file->values<std::int32_t>(path, H5T_NATIVE_INT32);
}

void Hdf5ImageReader::read_everything() {
  std::vector<std::string> groups = {""};
  while (!groups.empty() && !m_file->error) {
    const std::string group = std::move(groups.back());
    groups.pop_back();
    for (const std::string& member : members(group.empty() ? "/" : group)) {
      const std::string path = group + "/" + member;
      const Handle object(H5Oopen(m_file->file.id(), path.c_str(), H5P_DEFAULT), H5Oclose);
      if (H5Iget_type(object.id()) == H5I_GROUP)
        groups.push_back(path);
      else if (facts(path).type == ArrayType::int32)
        integers(path);
      else
        doubles(path);
    }
  }
}

} // namespace wry::pipeline
