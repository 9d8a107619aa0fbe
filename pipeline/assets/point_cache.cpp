#include "pipeline/assets/point_cache.h"

#include <cmath>
#include <cstring>

#include "pipeline/cache/atomic_file.h"

namespace wry::pipeline {

namespace {

constexpr std::size_t HEADER_BYTES = 32;
constexpr std::string_view MAGIC{"POINTCACHE2\0", 12};

template <class T> T number_at(const std::string& bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

} // namespace

Result<PointCache> read_point_cache(const std::filesystem::path& path, Eigen::Index vertices) {
  std::error_code ignored;
  if (const std::uintmax_t size = std::filesystem::file_size(path, ignored); !ignored && size > MOST_CACHE_BYTES)
    return make_error(ErrorCode::bad_input, "{}: {} bytes, at most {} are read", path.string(), size, MOST_CACHE_BYTES);
  const Result<std::string> bytes = read_whole_file(path);
  if (!bytes)
    return bytes.error();
  if (bytes->size() < HEADER_BYTES || !bytes->starts_with(MAGIC) || number_at<std::int32_t>(*bytes, 12) != 1)
    return make_error(ErrorCode::bad_input, "{}: this is no PC2 point cache of version 1", path.string());
  const auto points = static_cast<std::int64_t>(number_at<std::int32_t>(*bytes, 16));
  const auto samples = static_cast<std::int64_t>(number_at<std::int32_t>(*bytes, 28));
  PointCache cache;
  cache.first_frame = number_at<float>(*bytes, 20);
  cache.frames_per_sample = number_at<float>(*bytes, 24);
  if (points < 1 || points != vertices)
    return make_error(ErrorCode::bad_input,
                      "{}: moves {} points, the mesh has {}; export both from the same object, "
                      "without modifiers that change the topology",
                      path.string(), points, vertices);
  const bool sane = samples >= 1 && std::isfinite(cache.first_frame) && cache.frames_per_sample > 0.0 &&
                    std::isfinite(cache.frames_per_sample);
  if (!sane ||
      (bytes->size() - HEADER_BYTES) / 12 / static_cast<std::uint64_t>(points) < static_cast<std::uint64_t>(samples))
    return make_error(ErrorCode::bad_input, "{}: says {} samples of {} points every {} frames, but has {} bytes",
                      path.string(), samples, points, cache.frames_per_sample, bytes->size());
  for (std::int64_t sample = 0; sample < samples; ++sample) {
    Points positions(points, 3);
    for (std::int64_t i = 0; i < positions.size(); ++i) {
      const std::size_t offset = HEADER_BYTES + static_cast<std::size_t>(sample * points * 3 + i) * sizeof(float);
      positions.data()[i] = static_cast<double>(number_at<float>(*bytes, offset));
      if (!std::isfinite(positions.data()[i]))
        return make_error(ErrorCode::bad_input, "{}: sample {}, point {}: a coordinate is no number", path.string(),
                          sample, i / 3);
    }
    cache.samples.push_back(std::move(positions));
  }
  return cache;
}

} // namespace wry::pipeline
