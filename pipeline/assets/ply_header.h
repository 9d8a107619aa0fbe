#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/result.h"

namespace wry::pipeline {

enum class PlyType { i8, u8, i16, u16, i32, u32, f32, f64 };

/// Bytes of one value.
std::size_t ply_size(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::f32;
  bool is_list = false;
  PlyType count_type = PlyType::u8; ///< of lists
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /// The fewest bytes that one of them takes in a binary file.
  std::size_t least_size() const;
};

enum class PlyFormat { ascii, little_endian, big_endian };

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::size_t size = 0;  ///< bytes up to the data
  std::size_t lines = 0; ///< lines up to the data
};

/// Errors: bad_input with the line.
Result<PlyHeader> read_ply_header(std::string_view bytes);

} // namespace wry::pipeline
