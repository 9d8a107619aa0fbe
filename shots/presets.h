#pragma once

#include <string>

#include "shots/reference.h"
#include "shots/tree.h"

namespace wry::shots {

/// The values of a preset as a material table, each with Origin::preset. nullptr-like empty table: there is none.
Table preset_values(const std::string& name);

} // namespace wry::shots
