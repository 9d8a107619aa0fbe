#include "shots/schema.h"

#include <algorithm>
#include <set>

#include <nlohmann/json.hpp>

#include "shots/bind.h"
#include "shots/check.h"
#include "shots/reference.h"
#include "tests/shots/shots_support.h"

namespace wry::shots {
namespace {

/// "body.bunny.rotate[1].axis" as "body.*.rotate.axis".
std::string pattern_of(const std::string& key) {
  std::vector<std::string> parts(1);
  for (const char c : key) {
    if (c == '.') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  std::string pattern;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::string part = parts[i].substr(0, parts[i].find('['));
    const Field* top = shot_schema().find(parts[0]);
    const bool named = i == 1 && top && (top->kind == Kind::named_list || top->kind == Kind::named_tables);
    const bool channel =
        i == 2 && ((parts[0] == "render" && parts[1] == "heat") || (parts[0] == "contact" && parts[1] == "pair"));
    pattern += fmt::format("{}{}", i > 0 ? "." : "", named || channel ? "*" : part);
  }
  // Regions are the same wherever they stand.
  for (const std::string place : {"measure.*.where.", "drive.*.where.", "load.*.where."}) {
    if (pattern.rfind(place, 0) == 0) {
      return "fixed.*.where." + pattern.substr(place.size());
    }
  }
  return pattern;
}

/// Every key of the schema with "*" for names.
void collect_keys(const Section& section, const std::string& prefix, std::set<std::string>& keys) {
  for (const Field& field : section.fields) {
    if (!field.section && field.kind != Kind::free && field.key != "extends") {
      keys.insert(pattern_of(prefix + field.key));
    } else if (field.section) {
      const bool named = field.kind == Kind::named_list || field.kind == Kind::named_tables;
      collect_keys(*field.section, prefix + field.key + (named ? ".*." : "."), keys);
    }
  }
}

struct Seen {
  std::set<std::string> flat, read;
};

Seen see(const std::vector<Override>& overrides) {
  const Result<ShotDocument> document = read_document(data_file("every_key.toml"));
  const Result<ShotDocument> changed = apply_overrides(*document, overrides);
  Diagnostics diagnostics;
  const Table checked = check_document(*changed, diagnostics);
  EXPECT_TRUE(diagnostics.empty()) << diagnostics.error().message;
  ReadLog log;
  bind_shot(checked, "t.toml", ".", &log);
  Seen seen;
  for (const std::string& key : log) {
    seen.read.insert(pattern_of(key));
  }
  for (const FlatKey& key : flatten(*make_shot(*changed))) {
    seen.flat.insert(pattern_of(key.key));
  }
  return seen;
}

TEST(Schema, EveryKeyIsReadListedAndTested) {
  std::vector<Seen> all = {see({})};
  for (const char* camera : {"{ azimuth_deg = 1 }", "{ file = \"a.glb\", node = \"camera\" }",
                             "{ keys = [{ frame = 1, position = [1, 1, 1], target = [0, 0, 0], lens = 40 }] }"}) {
    all.push_back(see({*parse_override(std::string("render.camera=") + camera)}));
  }
  const auto any = [&](std::set<std::string> Seen::*set, const std::string& key) {
    return std::any_of(all.begin(), all.end(), [&](const Seen& seen) { return (seen.*set).contains(key); });
  };
  std::set<std::string> keys;
  collect_keys(shot_schema(), "", keys);
  EXPECT_GT(keys.size(), 120u);
  for (const std::string& key : keys) {
    EXPECT_TRUE(any(&Seen::flat, key)) << key << " is not in every_key.toml";
    EXPECT_TRUE(any(&Seen::read, key)) << key << " is in the schema, but nobody reads it";
  }
}

void check_fields(const Section& section, const std::string& path) {
  for (const Field& field : section.fields) {
    const std::string key = path + "." + field.key;
    EXPECT_FALSE(field.doc.empty()) << key;
    EXPECT_FALSE(expectation(field).empty()) << key;
    EXPECT_EQ(field.doc.back(), '.') << key;
    if (field.section) {
      check_fields(*field.section, key);
    }
    if (field.kind == Kind::choice || field.kind == Kind::word_list) {
      EXPECT_FALSE(field.words().empty()) << key;
    }
    if (field.value) {
      Diagnostics diagnostics;
      EXPECT_TRUE(check_value(field, *field.value, key, {}, {}, diagnostics)) << diagnostics.error().message;
    }
  }
}

TEST(Schema, EveryKeyIsExplainedAndItsDefaultIsValid) {
  check_fields(shot_schema(), "");
}

TEST(Schema, PresetsAreValidMaterials) {
  ASSERT_GE(list_presets().size(), 4u);
  for (const PresetInfo& preset : list_presets()) {
    const Result<Shot> shot = load_with(fmt::format("[material.p]\npreset = \"{}\"\n", preset.name));
    EXPECT_TRUE(shot.ok()) << shot.error().message;
    EXPECT_FALSE(preset.description.empty());
  }
}

TEST(Schema, JsonSchemaHasTheSameKeysAndLimits) {
  const nlohmann::json schema = nlohmann::json::parse(json_schema());
  EXPECT_EQ(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
  const auto& material = schema["properties"]["material"]["additionalProperties"];
  EXPECT_EQ(material["additionalProperties"], false);
  EXPECT_EQ(material["properties"]["poisson_ratio"]["exclusiveMaximum"], 0.5);
  EXPECT_EQ(material["properties"]["model"]["enum"].size(), 9u);
  EXPECT_EQ(material["properties"]["density"]["default"], 1000.0);
  EXPECT_EQ(material["properties"].size(), shot_schema().find("material")->section->fields.size());
  EXPECT_EQ(schema["properties"]["fem"]["properties"]["time_step"]["anyOf"][1]["const"], "auto");
  EXPECT_EQ(schema["properties"]["body"]["type"], "array");
}

TEST(Schema, ReferenceNamesEveryKey) {
  const std::string text = reference_markdown();
  for (const char* part : {"`youngs_modulus` | a positive modulus in Pa", "### `[[body]]`", "`curvature.stiffness.zz`",
                           "| `felt` |", "[[sweep.case]]", "`density` | a positive density in kg/m^3"}) {
    EXPECT_THAT(text, testing::HasSubstr(part));
  }
}

TEST(Schema, ListsChoices) {
  EXPECT_THAT(list_choices("material.*.model"), testing::Contains("micropolar-neo-hookean"));
  EXPECT_THAT(list_choices("material.*.model"), testing::Contains("plate"));
  EXPECT_THAT(list_choices("fem.linear_solver"), testing::SizeIs(4));
  EXPECT_THAT(list_choices("no.such.key"), testing::IsEmpty());
}

} // namespace
} // namespace wry::shots
