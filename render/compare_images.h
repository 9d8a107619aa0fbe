#pragma once

#include <string>

#include "render/image.h"
#include "sim/base/result.h"

namespace wry::render {

/// Left of the line one picture, right of it the other, each with its label at the top. `place`: of the line, 0 to 1.
/// Errors: bad_input for pictures of different sizes.
Result<Image> split_images(const Image& left, const Image& right, const std::string& left_label,
                           const std::string& right_label, double place = 0.5);

/// How far two pictures are apart, in grey levels of 255.
struct ImageDifference {
  double mean = 0.0;
  double greatest = 0.0;
  std::int64_t pixels_apart = 0; ///< with any channel different
  Image map;                     ///< the greatest of the three channels, as a heat map with its bar
};

/// `full`: the difference that has the last colour of the bar [grey levels]. Errors: as split_images().
Result<ImageDifference> difference_of_images(const Image& a, const Image& b, double full);

} // namespace wry::render
