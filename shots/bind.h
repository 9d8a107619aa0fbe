#pragma once

#include "shots/diagnostics.h"
#include "shots/reader.h"

namespace wry::shots {

/// The checked tree as a Shot. `log`, when given, collects the keys that were read.
Shot bind_shot(const Table& checked, const std::string& file, const std::string& directory, ReadLog* log = nullptr);

Body bind_body(const Reader& reader, const std::string& directory);
Material bind_material(const Reader& reader, const std::string& name);
RenderOptions bind_render(const Reader& reader);
Region bind_region(const Reader& reader);
Axis axis_of(const std::string& word);

/// What no single key can tell: keys that need each other, or exclude each other by value.
void check_rules(const Shot& shot, Diagnostics& diagnostics);

} // namespace wry::shots
