#include "sim/scene/expression_names.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <numeric>

namespace wry::scene {

namespace {

bool is_letter(char c) {
  return c == '_' || std::isalpha(static_cast<unsigned char>(c));
}

bool is_digit(char c) {
  return std::isdigit(static_cast<unsigned char>(c));
}

bool contains(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Levenshtein distance, where a change of case alone costs nothing extra beyond 1.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

std::string suggestion(std::string_view name, const ExpressionNames& known) {
  std::string best;
  std::size_t best_distance = 3;
  for (const std::vector<std::string>* names : {&known.variables, &known.functions}) {
    for (const std::string& candidate : *names) {
      const std::size_t distance = edit_distance(name, candidate);
      if (distance < best_distance && distance < std::max(name.size(), candidate.size())) {
        best = candidate;
        best_distance = distance;
      }
    }
  }
  // A single letter is one edit from every variable: only the other case is a likely slip.
  if (name.size() == 1) {
    best.clear();
    for (const std::string& candidate : known.variables)
      if (candidate.size() == 1 && std::tolower(candidate[0]) == std::tolower(name[0]))
        best = candidate;
  }
  if (!best.empty())
    return fmt::format("; did you mean '{}'?", best);
  return fmt::format("; known are {}", fmt::join(known.variables, ", "));
}

Status check_name(std::string_view text, std::size_t begin, std::size_t end, const ExpressionNames& known) {
  const std::string_view name = text.substr(begin, end - begin);
  std::size_t next = end;
  while (next < text.size() && std::isspace(static_cast<unsigned char>(text[next])))
    ++next;
  const bool is_call = next < text.size() && text[next] == '(';
  if (is_call && contains(known.functions, name))
    return {};
  if (!is_call && contains(known.variables, name))
    return {};
  if (!is_call && contains(known.functions, name))
    return make_error(ErrorCode::bad_input, "column {}: the function '{}' needs parentheses", begin + 1, name);
  if (is_call && contains(known.variables, name))
    return make_error(ErrorCode::bad_input, "column {}: '{}' is no function; write * to multiply", begin + 1, name);
  return make_error(ErrorCode::bad_input, "column {}: unknown {} '{}'{}", begin + 1, is_call ? "function" : "name",
                    name, suggestion(name, known));
}

// The end of the number that begins at `begin`.
Result<std::size_t> skip_number(std::string_view text, std::size_t begin) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data() + begin, text.data() + text.size(), value);
  const auto stop = static_cast<std::size_t>(end - text.data());
  if (error == std::errc::result_out_of_range)
    return make_error(ErrorCode::bad_input, "column {}: the number {} is out of range", begin + 1,
                      text.substr(begin, stop - begin));
  if (error != std::errc{})
    return make_error(ErrorCode::bad_input, "column {}: not a number", begin + 1);
  if (stop < text.size() && (is_letter(text[stop]) || text[stop] == '.'))
    return make_error(ErrorCode::bad_input, "column {}: '{}' right after a number; units have no place in formulas",
                      stop + 1, text[stop]);
  return stop;
}

Status check_sign(std::string_view text, std::size_t i) {
  const char c = text[i];
  if (c == '"' || c == '\'')
    return make_error(ErrorCode::bad_input, "column {}: formulas have no strings", i + 1);
  if (c == '=' && (i + 1 >= text.size() || text[i + 1] != '='))
    return make_error(ErrorCode::bad_input, "column {}: formulas cannot assign; compare with ==", i + 1);
  if (std::string_view("+-*/^()<>=!&|?:, \t\n\r").find(c) == std::string_view::npos)
    return make_error(ErrorCode::bad_input, "column {}: '{}' has no meaning in a formula", i + 1,
                      std::isprint(static_cast<unsigned char>(c))
                          ? std::string(1, c)
                          : fmt::format("\\x{:02x}", static_cast<unsigned char>(c)));
  return {};
}

} // namespace

bool is_expression_name(std::string_view name) {
  return !name.empty() && is_letter(name[0]) &&
         std::all_of(name.begin(), name.end(), [](char c) { return is_letter(c) || is_digit(c); });
}

Status check_expression_names(std::string_view text, const ExpressionNames& known) {
  for (std::size_t i = 0; i < text.size();) {
    if (is_letter(text[i])) {
      std::size_t end = i;
      while (end < text.size() && (is_letter(text[end]) || is_digit(text[end])))
        ++end;
      if (Status status = check_name(text, i, end, known); !status)
        return status;
      i = end;
    } else if (is_digit(text[i]) || text[i] == '.') {
      const Result<std::size_t> end = skip_number(text, i);
      if (!end)
        return end.error();
      i = *end;
    } else {
      if (Status status = check_sign(text, i); !status)
        return status;
      // Two-character comparisons are one sign.
      const bool is_pair =
          i + 1 < text.size() && text[i + 1] == '=' && std::string_view("<>!=").find(text[i]) != std::string_view::npos;
      i += is_pair ? 2 : 1;
    }
  }
  return {};
}

} // namespace wry::scene
