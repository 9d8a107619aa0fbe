#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/image.h"
#include "sim/base/result.h"

namespace wry::render {

/// One channel of an OpenEXR picture, rows from the top.
struct ExrChannel {
  enum class Type { half_float, float32, integer };
  std::string name; ///< "R", "Z", "N.X", "velocity.Y", "id"
  Type type = Type::half_float;
  std::vector<float> values; ///< height x width; whole numbers for Type::integer
};

/// A picture of any number of layers, all of one size.
struct ExrImage {
  int width = 0;
  int height = 0;
  std::vector<ExrChannel> channels;
  std::vector<std::pair<std::string, std::string>> texts; ///< header attributes
};

/// Writes linear Rec. 709 light and its layers, ZIP-compressed, with `chromaticities` and `colorspace` = "lin_rec709",
/// aside and renamed. Errors: cannot_write, io; bad_input for channels of another size.
Status write_exr(const std::filesystem::path& path, const ExrImage& image);

/// All channels of a picture in one part. Errors: missing_input, bad_input.
Result<ExrImage> read_exr(const std::filesystem::path& path);

/// The channels R, G and B. Errors: as read_exr(), and bad_input without them.
Result<LinearImage> read_exr_light(const std::filesystem::path& path);

} // namespace wry::render
