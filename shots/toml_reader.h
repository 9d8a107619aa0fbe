#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "shots/tree.h"
#include "sim/base/result.h"

namespace wry::shots {

/// TOML 1.0 to a tree. Errors: bad_input with file:line:column for what is no TOML, or is beyond the limits of
/// shots/load.h (size, nesting, keys of one table).
Result<Table> parse_toml(std::string_view text, const std::string& file, int layer);

/// One value such as `5e4`, `[1, 2]` or `{ height = 1 }`; nullopt when the text is no TOML value.
std::optional<Value> parse_toml_value(std::string_view text, const Place& place);

/// Refuses text whose nesting could exhaust the stack of a recursive parser: brackets and dotted keys deeper than
/// MAX_DEPTH. Strings and comments are skipped. Errors: bad_input with the place.
Status check_toml_nesting(std::string_view text, const std::string& file);

} // namespace wry::shots
