#include <cmath>

#include <nlohmann/json.hpp>

#include "shots/reference.h"
#include "shots/schema.h"

namespace wry::shots {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* NAME_PATTERN = "^[A-Za-z0-9_][A-Za-z0-9_-]{0,63}$";

Json section_schema(const Section& section);

Json to_json(const Value& value) {
  if (const auto* boolean = value.get<bool>()) {
    return *boolean;
  }
  if (const auto* integer = value.get<std::int64_t>()) {
    return *integer;
  }
  if (const auto* text = value.get<std::string>()) {
    return *text;
  }
  if (const auto* list = value.get<Array>()) {
    Json array = Json::array();
    for (const Value& item : *list) {
      array.push_back(to_json(item));
    }
    return array;
  }
  return value.number();
}

Json number_schema(const Interval& range, const char* type) {
  Json schema{{"type", type}};
  if (std::isfinite(range.low)) {
    schema[range.low_open ? "exclusiveMinimum" : "minimum"] = range.low;
  }
  if (std::isfinite(range.high)) {
    schema[range.high_open ? "exclusiveMaximum" : "maximum"] = range.high;
  }
  return schema;
}

Json list_schema(Json item, int length) {
  return Json{{"type", "array"}, {"items", std::move(item)}, {"minItems", length}, {"maxItems", length}};
}

Json word_schema(const Field& field) {
  return Json{{"enum", field.words()}};
}

Json some_of(Json item) {
  Json list{{"type", "array"}, {"items", item}, {"minItems", 1}, {"uniqueItems", true}};
  return Json{{"anyOf", Json::array({std::move(item), std::move(list)})}};
}

Json text_schema(const char* pattern) {
  return Json{{"type", "string"}, {"pattern", pattern}};
}

Json kind_schema(const Field& field) {
  const Json vector = list_schema(number_schema(any_number(), "number"), 3);
  switch (field.kind) {
  case Kind::boolean:
    return Json{{"type", "boolean"}};
  case Kind::integer:
    return number_schema(field.range, "integer");
  case Kind::number:
    return number_schema(field.range, "number");
  case Kind::choice:
    return word_schema(field);
  case Kind::word_list:
    return some_of(word_schema(field));
  case Kind::view_list:
    return some_of(text_schema("^(beauty|clay|wire|directors|fibres|contacts|heat\\.[A-Za-z0-9_][A-Za-z0-9_-]*)$"));
  case Kind::name:
  case Kind::reference:
    return Json{{"type", "string"}, {"minLength", 1}, {"maxLength", 64}};
  case Kind::text:
  case Kind::path:
    return Json{{"type", "string"}, {"minLength", 1}};
  case Kind::frames:
    return Json{{"anyOf", Json::array({text_schema("^ *\\d+.*$"), number_schema(between(0, 1e7), "integer")})}};
  case Kind::expression:
    return Json{{"anyOf", Json::array({number_schema(any_number(), "number"), Json{{"type", "string"}}})}};
  case Kind::numbers:
    return list_schema(number_schema(field.range, "number"), field.length);
  case Kind::integers:
    return list_schema(number_schema(field.range, "integer"), field.length);
  case Kind::colour:
    return Json{{"anyOf", Json::array({list_schema(number_schema(between(0, 1), "number"), 3),
                                       text_schema("^#[0-9a-fA-F]{6}$")})}};
  case Kind::direction:
    return Json{{"anyOf", Json::array({vector, text_schema("^-?[xyz]$")})}};
  case Kind::matrix:
    return list_schema(vector, 3);
  case Kind::table:
    return section_schema(*field.section);
  case Kind::table_list:
    return some_of(section_schema(*field.section));
  case Kind::named_list:
    return Json{{"type", "array"}, {"items", section_schema(*field.section)}};
  case Kind::named_tables:
    return Json{{"type", "object"},
                {"propertyNames", Json{{"pattern", NAME_PATTERN}}},
                {"additionalProperties", section_schema(*field.section)}};
  case Kind::free:
    return Json{{"type", "object"}};
  }
  return {};
}

Json field_schema(const Field& field) {
  Json schema = kind_schema(field);
  if (field.section && field.kind == Kind::number) {
    schema["type"] = Json::array({"number", "object"});
    schema.update(Json{{"additionalProperties", false}, {"properties", section_schema(*field.section)["properties"]}});
  }
  if (!field.word.empty()) {
    schema = Json{{"anyOf", Json::array({std::move(schema), Json{{"const", field.word}}})}};
  }
  std::string description = field.doc;
  if (!field.unit.empty()) {
    description += " [" + field.unit + "]";
  }
  if (!field.default_note.empty()) {
    description += " Default: " + field.default_note + ".";
  }
  if (field.is_required) {
    description += " Has to be given, here, by a preset or by the extended file.";
  }
  schema["description"] = description;
  if (field.value) {
    schema["default"] = to_json(*field.value);
  }
  return schema;
}

/// Keys are not `required` here: they may come from a preset or from the file that is extended.
Json section_schema(const Section& section) {
  Json properties = Json::object();
  for (const Field& field : section.fields) {
    properties[field.key] = field_schema(field);
  }
  Json schema{{"type", "object"}, {"additionalProperties", false}, {"properties", std::move(properties)}};
  Json clashes = Json::array();
  for (const OneOf& group : section.one_of) {
    for (std::size_t i = 0; i < group.alternatives.size(); ++i) {
      for (std::size_t j = i + 1; j < group.alternatives.size(); ++j) {
        for (const std::string& a : group.alternatives[i]) {
          for (const std::string& b : group.alternatives[j]) {
            clashes.push_back(Json{{"required", {a, b}}});
          }
        }
      }
    }
  }
  if (!clashes.empty()) {
    schema["not"] = Json{{"anyOf", std::move(clashes)}};
  }
  return schema;
}

} // namespace

std::string json_schema() {
  Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
              {"title", "wry shot file"},
              {"description", shot_schema().doc}};
  schema.update(section_schema(shot_schema()));
  return schema.dump(2) + "\n";
}

} // namespace wry::shots
