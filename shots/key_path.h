#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "shots/tree.h"
#include "sim/base/result.h"

namespace wry::shots {

/// "body.bunny.resolution" as its parts; parts may be quoted. Errors: bad_input, without a place.
Result<std::vector<std::string>> split_key(std::string_view key);

/// Whether set_at would find its way. Errors: bad_input, without a place, naming the nearest name.
Status check_key(const Table& root, std::string_view key);

/// Puts a value at a dotted key: array tables by name, other lists by index from 0, tables on the way are made.
/// Errors: bad_input, without a place, when the key leads nowhere.
Status set_at(Table& root, std::string_view key, Value value);

} // namespace wry::shots
