#pragma once

#include <map>
#include <string>
#include <vector>

#include "shots/diagnostics.h"
#include "shots/load.h"
#include "shots/schema.h"
#include "shots/tree.h"

namespace wry::shots {

/// Names that references can mean, per section: "material" -> skin, wall.
using KnownNames = std::map<std::string, std::vector<std::string>>;

/// Where paths are relative to.
struct PathBase {
  std::string main_file; ///< paths that stand here, or on the command line, are relative to `directory`
  std::string directory;
};

/// The document with every key checked, defaults, presets and derived defaults filled in, keys in the order of the
/// schema, numbers as floats where the schema says number, paths relative to the main file's folder. What is wrong goes
/// to `diagnostics` and is left out of the answer.
Table check_document(const ShotDocument& document, Diagnostics& diagnostics);

/// Defaults that follow from other keys: the shot's name, gravity, the only body, what a plane is.
void fill_derived_defaults(Table& root, const std::string& file);

/// A rod is square unless a height was given; needs checked widths.
void fill_rod_heights(Table& checked);

/// Gives fixed1, collider2, ... to what has no name.
void name_unnamed(Table& root);

/// Checks one value against its field; nullopt when it is wrong. Tables are not its business.
std::optional<Value> check_value(const Field& field, const Value& value, const std::string& key,
                                 const KnownNames& names, const PathBase& paths, Diagnostics& diagnostics);

/// "a positive modulus in Pa": what a field takes.
std::string expectation(const Field& field);

/// Whether a name is made of letters, digits, _ and - (and dots within, where allowed), so that it is safe in file
/// names and in dotted keys.
enum class Dots { refused, allowed };
bool is_safe_name(std::string_view name, Dots dots);

/// Whether the table can be left out because all its keys can.
bool can_be_empty(const Section& section);

} // namespace wry::shots
