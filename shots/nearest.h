#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace wry::shots {

/// Edits from one word to the other: insertions, deletions, replacements and swaps of neighbours (Damerau-Levenshtein,
/// optimal string alignment). Letters differ by case for half an edit, hence the result counts half edits.
int half_edits(std::string_view from, std::string_view to);

/// The candidate that is the least edits away, the first of equals; empty when none is near enough to be meant.
std::string nearest(std::string_view word, const std::vector<std::string>& candidates);

/// "; did you mean 'density'?", or "; known: a, b, c" when nothing is near, for the end of a message.
std::string suggestion(std::string_view word, const std::vector<std::string>& candidates);

} // namespace wry::shots
