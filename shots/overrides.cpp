#include <fmt/format.h>

#include "shots/check.h"
#include "shots/diagnostics.h"
#include "shots/key_path.h"
#include "shots/load.h"
#include "shots/nearest.h"
#include "shots/sweep_plan.h"
#include "shots/toml_reader.h"

namespace wry::shots {
namespace {

constexpr int COMMAND_LINE_LAYER = 100, CASE_LAYER = 99;

Place place_of(const Override& change) {
  Place place;
  place.file = std::make_shared<const std::string>(change.source.file.empty() ? "--set" : change.source.file);
  place.line = change.source.line;
  place.column = change.source.column;
  place.origin = Origin::command_line;
  place.layer = COMMAND_LINE_LAYER;
  return place;
}

/// Changes the place of a value and of all that is in it.
template <class Change> void for_all_places(Value& value, const Change& change) {
  change(value.place);
  if (Array* list = value.get<Array>()) {
    for (Value& item : *list) {
      for_all_places(item, change);
    }
  }
  if (Table* table = value.get<Table>()) {
    for (Entry& entry : table->entries()) {
      change(entry.key_place);
      for_all_places(entry.value, change);
    }
  }
}

/// Applies one key; what is wrong goes to `diagnostics`.
void apply(Table& root, const std::string& key, Value value, Diagnostics& diagnostics) {
  const Source source = value.place.source(excerpt(key));
  if (key == "extends" || key.rfind("sweep.applied", 0) == 0) {
    diagnostics.add(source, ": this key cannot be set from outside the file");
    return;
  }
  if (const Status set = set_at(root, key, std::move(value)); !set) {
    diagnostics.add(source, ": " + set.error().message);
  }
}

void apply_case(Table& root, const Override& change, Diagnostics& diagnostics) {
  Diagnostics ignored; // make_shot reports what is wrong with the sweep
  const SweepPlan sweep = plan_sweep(root, ignored);
  std::vector<std::string> names;
  for (const SweepCase& sweep_case : sweep.cases) {
    names.push_back(sweep_case.name);
    if (sweep_case.name != change.value) {
      continue;
    }
    for (const auto& [key, value] : sweep_case.set) {
      Value strong = value;
      for_all_places(strong, [](Place& place) { place.layer = CASE_LAYER; });
      apply(root, key, std::move(strong), diagnostics);
    }
    root.find("sweep")->get<Table>()->set("applied", Value(sweep_case.name, place_of(change)));
    return;
  }
  diagnostics.add(place_of(change).source("case"), fmt::format(" = {}: there is no [[sweep.case]] with this name{}",
                                                               excerpt(change.value), suggestion(change.value, names)));
}

} // namespace

Result<Override> parse_override(std::string_view text) {
  // A quoted part of a key may hold "=".
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quote != 0) {
      quote = c == quote ? 0 : quote;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '=') {
      const auto trim = [](std::string_view part) {
        const auto begin = part.find_first_not_of(' ');
        return begin == std::string_view::npos
                   ? std::string()
                   : std::string(part.substr(begin, part.find_last_not_of(' ') - begin + 1));
      };
      Override change{trim(text.substr(0, i)), trim(text.substr(i + 1)), {}};
      if (change.key.empty() || change.value.empty()) {
        break;
      }
      return change;
    }
  }
  return make_error(ErrorCode::usage, "--set {}: expected key=value, such as --set material.skin.youngs_modulus=1e5",
                    excerpt(text));
}

Result<ShotDocument> apply_overrides(const ShotDocument& document, const std::vector<Override>& overrides) {
  auto root = std::make_shared<Table>(document.root());
  Diagnostics diagnostics;
  for (const Override& change : overrides) {
    if (change.key == "case") {
      apply_case(*root, change, diagnostics);
    }
  }
  for (const Override& change : overrides) {
    if (change.key == "case") {
      continue;
    }
    const Place place = place_of(change);
    Value value = parse_toml_value(change.value, place).value_or(Value(change.value, place));
    for_all_places(value, [&](Place& part) { part = place; }); // not where it stands in the argument
    value.raw = change.value;
    apply(*root, change.key, std::move(value), diagnostics);
  }
  if (!diagnostics.empty()) {
    return diagnostics.error();
  }
  return ShotDocument(document.file(), document.directory(), std::move(root));
}

} // namespace wry::shots
