#include "shots/reference.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "shots/check.h"
#include "shots/key_path.h"
#include "shots/schema.h"

namespace wry::shots {
namespace {

/// Bars end a cell of a Markdown table.
std::string cell(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') {
      escaped += '\\';
    }
    escaped += c;
  }
  return escaped;
}

std::string default_text(const Field& field) {
  if (field.is_required) {
    return "*has to be given*";
  }
  if (!field.default_note.empty()) {
    return field.word.empty() ? field.default_note : fmt::format("`\"{}\"`: {}", field.word, field.default_note);
  }
  return field.value ? fmt::format("`{}`", to_toml(*field.value)) : "none";
}

std::string meaning(const Field& field) {
  std::string text = field.doc;
  for (const Choice& option : field.choices) {
    if (option.refusal.empty() && !option.doc.empty()) {
      text += fmt::format(" `{}`: {}.", option.word, option.doc);
    }
  }
  return text;
}

/// Of numbers in whose place a table may stand.
std::string or_table(const Field& field) {
  return field.kind == Kind::number && field.section
             ? fmt::format(", or a table {{ {} }}", fmt::join(field.section->keys(), ", "))
             : std::string();
}

/// Rows of a table of keys; what is nested follows with dotted keys.
std::string rows(const Section& section, const std::string& prefix) {
  std::string text;
  for (const Field& field : section.fields) {
    const bool nested = field.section != nullptr && field.kind != Kind::number;
    const std::string key = prefix + field.key;
    text += fmt::format("| `{}` | {} | {} | {} |\n", key,
                        nested ? (field.kind == Kind::table_list ? "table or list of tables" : "table")
                               : cell(expectation(field) + or_table(field)),
                        nested && !field.is_required ? "" : cell(default_text(field)), cell(meaning(field)));
    if (nested) {
      text += rows(*field.section, key + (field.kind == Kind::named_tables ? ".<name>." : "."));
    }
  }
  return text;
}

std::string heading(const Field& field) {
  switch (field.kind) {
  case Kind::named_list:
    return fmt::format("[[{}]]", field.key);
  case Kind::named_tables:
    return fmt::format("[{}.<name>]", field.key);
  case Kind::table:
  case Kind::free:
    return fmt::format("[{}]", field.key);
  default:
    return field.key;
  }
}

constexpr const char* SWEEP_TEXT = R"(
```toml
[sweep]
mode = "grid"                                   # or "zip", or "latin-hypercube" with samples = N and shot.seed
"material.skin.length_scale" = [0, 0.1, 1]      # a list
"material.skin.youngs_modulus" = { from = 1e4, to = 1e6, count = 3, scale = "log" }   # or a range; scale "linear"

[[sweep.case]]                                  # named variants; the lists are run for each of them
name = "soft"
set = { "material.skin.model" = "neo-hookean", "material.skin.youngs_modulus" = 5e4 }
```

`--set case=soft` applies one case to a single run. Array tables are reached by name: `"body.bunny.resolution"`.
)";

constexpr const char* ACCURACY_TEXT = R"(
```toml
[accuracy]
frames = "1-13"                                 # default: the shot's
tolerance = 0.01                                # relative error that the recommendation is for
reference_factor = 4                            # how much finer than its finest rung a ladder's reference is
"fem.time_step" = [0.04, 0.02, 0.01]            # ladders: one key each, from coarse to fine; all else as in the shot
"body.bar.resolution" = { from = 0.1, to = 0.025, count = 3, scale = "log" }
reference = { "fem.time_step" = 1e-3 }          # or one reference for every ladder
exact = { tip = -0.0123 }                       # or the value of a measure in the last frame, from a closed form
```
)";

constexpr const char* STRESS_TEXT = R"(
```toml
[stress]
frames = "1-13"                                 # default: the shot's
time_limit = 60                                 # [s] for each case
pairs = true                                    # the extremes of every two knobs together, too
"material.skin.youngs_modulus" = { from = 1e2, to = 1e12, count = 6, scale = "log" }
```

Without any key of the shot in it, `wry stress` takes the knobs that the shot has.
)";

const char* text_of_free(const std::string& key) {
  return key == "sweep" ? SWEEP_TEXT : key == "accuracy" ? ACCURACY_TEXT : STRESS_TEXT;
}

} // namespace

std::string reference_markdown() {
  std::string text = shot_schema().doc + "\n";
  for (const Field& field : shot_schema().fields) {
    text += fmt::format("\n### `{}`\n\n{}\n", heading(field), field.doc);
    if (field.section) {
      text += "\n| key | takes | default | meaning |\n|---|---|---|---|\n" + rows(*field.section, "");
    } else if (field.kind == Kind::free) {
      text += text_of_free(field.key);
    }
  }
  text += "\n### Presets\n\n| preset | what it is |\n|---|---|\n";
  for (const PresetInfo& preset : list_presets()) {
    text += fmt::format("| `{}` | {} |\n", preset.name, cell(preset.description));
  }
  return text;
}

std::vector<std::string> list_choices(const std::string& key_pattern) {
  const Result<std::vector<std::string>> parts = split_key(key_pattern);
  const Section* section = &shot_schema();
  const Field* field = nullptr;
  for (std::size_t i = 0; parts && i < parts->size(); ++i) {
    if ((*parts)[i] == "*") {
      continue;
    }
    field = section ? section->find((*parts)[i]) : nullptr;
    section = field ? field->section.get() : nullptr;
  }
  return field ? field->words() : std::vector<std::string>{};
}

} // namespace wry::shots
