#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/base/result.h"

namespace wry::scene {

/// What a formula may name.
struct ExpressionNames {
  std::vector<std::string> variables; ///< and constants
  std::vector<std::string> functions;
};

/// Whether it can stand in a formula: a letter or underscore, then letters, digits, underscores.
bool is_expression_name(std::string_view name);

/// bad_input with the column for unknown names (and the nearest known one), assignments, strings and numbers run into
/// names.
Status check_expression_names(std::string_view text, const ExpressionNames& known);

} // namespace wry::scene
