#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/result.h"

namespace wry::shots {

/// Frames first, first + step, ... not beyond last.
struct FrameSpan {
  int first = 1;
  int last = 1;
  int step = 1;
};

/// A set of frame numbers such as 1001-1100x2,1150. Numbers are sorted and never repeat.
class FrameRange {
public:
  static constexpr int MAX_FRAME = 10'000'000;
  static constexpr std::int64_t MAX_COUNT = 1'000'000;

  FrameRange() = default;
  /// Parses "1-120", "1001-1100x2,1150", "7". Errors: bad_input when a number is negative or beyond MAX_FRAME, a range
  /// runs backwards, or more than MAX_COUNT frames are asked for; the message has no place, the caller knows it.
  static Result<FrameRange> parse(std::string_view text);

  int first() const { return m_frames.front(); }
  int last() const { return m_frames.back(); }
  std::size_t count() const { return m_frames.size(); }
  bool contains(int frame) const;
  /// Ascending.
  const std::vector<int>& frames() const { return m_frames; }
  /// The same set in canonical text: equal sets have equal text.
  std::string text() const;

private:
  std::vector<int> m_frames{1};
};

} // namespace wry::shots
