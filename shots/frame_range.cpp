#include "shots/frame_range.h"

#include <algorithm>
#include <charconv>

namespace wry::shots {
namespace {

std::string_view trim(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) {
    return {};
  }
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

std::string shorten(std::string_view text) {
  constexpr std::size_t LONGEST = 60;
  return text.size() <= LONGEST ? std::string(text) : std::string(text.substr(0, LONGEST)) + "...";
}

Result<int> parse_number(std::string_view text, std::string_view whole) {
  int number = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || text.front() == '-' || problem == std::errc::invalid_argument ||
      end != text.data() + text.size()) {
    return make_error(ErrorCode::bad_input,
                      "'{}' in frames '{}': expected a frame number, a range such as 1-120 or a "
                      "range with a step such as 1001-1100x2, separated by commas",
                      shorten(text), shorten(whole));
  }
  if (problem != std::errc{} || number > FrameRange::MAX_FRAME) {
    return make_error(ErrorCode::bad_input, "frame '{}': frame numbers go from 0 to {}", shorten(text),
                      FrameRange::MAX_FRAME);
  }
  return number;
}

Result<FrameSpan> parse_span(std::string_view text, std::string_view whole) {
  FrameSpan span;
  std::string_view range = text;
  if (const auto times = text.find('x'); times != std::string_view::npos) {
    const Result<int> step = parse_number(trim(text.substr(times + 1)), whole);
    if (!step) {
      return step.error();
    }
    if (*step < 1) {
      return make_error(ErrorCode::bad_input, "frames '{}': the step after x must be at least 1", shorten(text));
    }
    span.step = *step;
    range = text.substr(0, times);
  }
  const auto dash = range.find('-', 1 < range.size() ? 1 : range.size());
  const Result<int> first = parse_number(trim(range.substr(0, dash)), whole);
  if (!first) {
    return first.error();
  }
  span.first = span.last = *first;
  if (dash != std::string_view::npos) {
    const Result<int> last = parse_number(trim(range.substr(dash + 1)), whole);
    if (!last) {
      return last.error();
    }
    span.last = *last;
  }
  if (span.last < span.first) {
    return make_error(ErrorCode::bad_input, "frames '{}': the range runs backwards; write {}-{}", shorten(text),
                      span.last, span.first);
  }
  return span;
}

} // namespace

Result<FrameRange> FrameRange::parse(std::string_view text) {
  std::vector<int> frames;
  std::string_view rest = text;
  for (bool more = true; more;) {
    const auto comma = rest.find(',');
    const Result<FrameSpan> span = parse_span(trim(rest.substr(0, comma)), text);
    if (!span) {
      return span.error();
    }
    const std::int64_t count = (std::int64_t{span->last} - span->first) / span->step + 1;
    if (count + static_cast<std::int64_t>(frames.size()) > MAX_COUNT) {
      return make_error(ErrorCode::bad_input, "frames '{}': more than {} frames; split the shot", shorten(text),
                        MAX_COUNT);
    }
    for (std::int64_t i = 0; i < count; ++i) {
      frames.push_back(span->first + static_cast<int>(i) * span->step);
    }
    more = comma != std::string_view::npos;
    rest = more ? rest.substr(comma + 1) : std::string_view{};
  }
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  FrameRange range;
  range.m_frames = std::move(frames);
  return range;
}

bool FrameRange::contains(int frame) const {
  return std::binary_search(m_frames.begin(), m_frames.end(), frame);
}

std::string FrameRange::text() const {
  std::string text;
  for (std::size_t i = 0; i < m_frames.size();) {
    // The longest run of equal steps from here; two frames alone are no run unless they are neighbours.
    std::size_t end = i + 1;
    const int step = end < m_frames.size() ? m_frames[end] - m_frames[i] : 1;
    while (end < m_frames.size() && m_frames[end] - m_frames[end - 1] == step) {
      ++end;
    }
    if (end - i == 2 && step != 1) {
      end = i + 1;
    }
    text += fmt::format("{}{}", text.empty() ? "" : ",", m_frames[i]);
    if (end - i > 1) {
      text += fmt::format("-{}{}", m_frames[end - 1], step > 1 ? fmt::format("x{}", step) : "");
    }
    i = end;
  }
  return text;
}

} // namespace wry::shots
