#pragma once

#include <string>
#include <vector>

namespace wry::shots {

/// JSON Schema (draft 2020-12) of the shot file, from the table that the parser reads.
std::string json_schema();

/// Every key with type, unit, range, default and meaning as Markdown tables, a section per table of the shot file.
std::string reference_markdown();

/// A material preset and where its values come from, for `wry list`.
struct PresetInfo {
  std::string name;
  std::string description;
};
std::vector<PresetInfo> list_presets();

/// Looks that a body can name without a [look.X]; the renderer describes them.
std::vector<std::string> list_built_in_looks();

/// Names a choice key takes, for `wry list`: list_choices("material.*.model"). Empty when the key has no choices.
std::vector<std::string> list_choices(const std::string& key_pattern);

} // namespace wry::shots
