#include "shots/nearest.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace wry::shots {
namespace {

constexpr std::size_t LONGEST = 64;

char lower(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

int replacement(char a, char b) {
  return a == b ? 0 : lower(a) == lower(b) ? 1 : 2;
}

} // namespace

int half_edits(std::string_view from, std::string_view to) {
  const std::size_t rows = from.size(), columns = to.size();
  std::vector<int> before(columns + 1), previous(columns + 1), current(columns + 1);
  for (std::size_t j = 0; j <= columns; ++j) {
    previous[j] = 2 * static_cast<int>(j);
  }
  for (std::size_t i = 1; i <= rows; ++i) {
    current[0] = 2 * static_cast<int>(i);
    for (std::size_t j = 1; j <= columns; ++j) {
      current[j] =
          std::min({previous[j] + 2, current[j - 1] + 2, previous[j - 1] + replacement(from[i - 1], to[j - 1])});
      if (i > 1 && j > 1 && from[i - 1] == to[j - 2] && from[i - 2] == to[j - 1]) {
        current[j] = std::min(current[j], before[j - 2] + 2);
      }
    }
    std::swap(before, previous);
    std::swap(previous, current);
  }
  return previous[columns];
}

std::string nearest(std::string_view word, const std::vector<std::string>& candidates) {
  if (word.size() > LONGEST) {
    return {};
  }
  std::string best;
  int least = 2 * std::max(2, static_cast<int>(word.size()) / 2) + 1;
  for (const std::string& candidate : candidates) {
    const int edits = half_edits(word, candidate);
    // All letters replaced is no likeness, however short the words.
    if (edits < least && edits < 2 * static_cast<int>(std::max(word.size(), candidate.size()))) {
      least = edits;
      best = candidate;
    }
  }
  return best;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& candidates) {
  if (const std::string best = nearest(word, candidates); !best.empty()) {
    return fmt::format("; did you mean '{}'?", best);
  }
  if (candidates.empty()) {
    return {};
  }
  constexpr std::size_t MOST = 24;
  const std::vector<std::string> shown(candidates.begin(), candidates.begin() + std::min(MOST, candidates.size()));
  return fmt::format("; known: {}{}", fmt::join(shown, ", "), candidates.size() > MOST ? ", ..." : "");
}

} // namespace wry::shots
