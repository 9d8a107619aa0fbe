#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shots/resolved.h"
#include "shots/tree.h"

/// The one description of the shot file. Parsing, checking, defaults, the JSON Schema, the reference and what a changed
/// key makes stale are all read from it; a new key is one line in a schema_*.cpp and one in a bind_*.cpp.
namespace wry::shots {

enum class Kind {
  boolean,
  integer,
  number,
  choice,       ///< one of a few words
  word_list,    ///< a list of some of a few words, none twice
  name,         ///< what the user calls a thing
  reference,    ///< the name of a thing that must exist
  view_list,    ///< names of views: beauty, heat.speed
  text,         ///< free, short
  path,         ///< a file, relative to the shot's folder
  frames,       ///< 1001-1100x2,1150
  expression,   ///< a number or a formula
  numbers,      ///< a list of `length` numbers
  integers,     ///< a list of `length` integers
  colour,       ///< [r, g, b] in 0..1 or "#rrggbb"
  direction,    ///< [x, y, z], not zero, or "x", "-y", ...
  matrix,       ///< three lists of three numbers
  table,        ///< keys of `section`
  table_list,   ///< one table or a list of tables without names
  named_list,   ///< [[body]]: tables with a name each
  named_tables, ///< [material.X]: the name is the key
  free,         ///< checked elsewhere: [sweep], [accuracy], [stress]
};

/// Numbers between two ends, each in or out.
struct Interval {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false, high_open = false;

  bool contains(double number) const;
  std::string text() const; ///< "(-1, 0.5)", ">= 0", "> 0"; empty: all numbers
};

Interval any_number();
Interval positive(double high = 1e15);
Interval at_least_zero(double high = 1e15);
Interval between(double low, double high);
Interval strictly_between(double low, double high);

/// A word of a choice key. A refusal, when not empty, says why it cannot be had in this build.
struct Choice {
  std::string word;
  std::string doc;
  std::string refusal;
};

struct Section;

/// One key.
struct Field {
  std::string key;
  Kind kind = Kind::number;
  std::string doc;
  std::string unit;           ///< "Pa"; empty: none
  std::string noun;           ///< "modulus": what a message calls it; empty: "number"
  Interval range;             ///< of numbers, of each entry of lists
  int length = 3;             ///< of numbers and integers
  std::optional<Value> value; ///< the default
  std::string default_note;   ///< the default in words, when it is derived or absent
  bool is_required = false;
  std::string word;                       ///< "auto": may stand in place of the number
  std::string target;                     ///< of references: the section that has the name
  std::string hint;                       ///< what to do when it is out of range
  std::vector<Choice> choices;            ///< of choice, word_list
  std::optional<Effect> effect;           ///< absent: that of the section
  std::shared_ptr<const Section> section; ///< of tables, and of numbers in whose place a table may stand

  Field standard(Value data) const; ///< with a default
  Field standard(bool data) const { return standard(Value(data)); }
  Field standard(int data) const { return standard(Value(std::int64_t{data})); }
  Field standard(double data) const { return standard(Value(data)); }
  Field standard(const char* data) const { return standard(Value(std::string(data))); }
  Field default_is(std::string note) const; ///< with a default that is derived, in words
  Field required() const;
  Field or_word(std::string word_, std::string note) const; ///< default: the word
  Field affects(Effect effect_) const;
  Field called(std::string noun_) const;
  Field advice(std::string hint_) const;
  /// Of a number: in its place a table with a number for each of these keys may stand, within `range_`.
  Field or_per(std::vector<std::string> keys_, Interval range_) const;
  std::vector<std::string> words() const; ///< of the choices that this build has
};

/// Keys of which only one alternative can stand.
struct OneOf {
  std::vector<std::vector<std::string>> alternatives;
  bool is_required = false;
  std::string what; ///< "shape": what they describe
};

/// A key that the design has and this build has not yet.
struct Later {
  std::string key;
  std::string what; ///< "the material point method"
};

/// A table of the shot file.
struct Section {
  std::string doc;
  std::optional<Effect> effect; ///< absent: that of the table around it; of the file: simulation
  std::vector<Field> fields;
  std::vector<OneOf> one_of;
  std::vector<Later> later;

  const Field* find(std::string_view key) const; ///< nullptr: no such key
  std::vector<std::string> keys() const;
};

Field boolean(std::string key, std::string doc);
Field integer(std::string key, Interval range, std::string doc);
Field number(std::string key, std::string unit, Interval range, std::string doc);
Field choice(std::string key, std::vector<Choice> choices, std::string doc);
Field word_list(std::string key, std::vector<Choice> choices, std::string doc);
Field numbers(std::string key, int length, std::string unit, Interval range, std::string doc);
Field integers(std::string key, int length, Interval range, std::string doc);
Field reference(std::string key, std::string target, std::string doc);
Field plain(std::string key, Kind kind, std::string doc);
Field nested(std::string key, Kind kind, Section section, std::string doc);

/// A list of numbers as a default.
Value number_list(std::vector<double> list);
Value text_list(std::vector<std::string> list);

/// The whole shot file.
const Section& shot_schema();

// Its parts, a file each.
Section shot_section();
Section body_section();
Section material_section();
Section fixed_section();
Section drive_section();
Section load_section();
/// rest_rotation = { x, y, z } of a body.
Field rest_rotation_field();
Section collider_section();
Section look_section();
Section fem_section();
Section contact_section();
Section mpm_section();
/// Keys of [material.X] and [[body]] that only the material point method reads.
std::vector<Field> mpm_material_fields();
std::vector<Field> mpm_body_fields();
Field reorient_field();
Field sub_particles_field();
Section render_section();
Section measure_section();
Section expect_section();
/// size, scale, units, up, rotate, translate: how a shape or mesh file comes into the shot's world.
std::vector<Field> placement_fields();
/// keys, pivot, ease: how something moves as a whole.
std::vector<Field> motion_fields();
/// where = { ... }: how nodes are picked.
Section region_section();

} // namespace wry::shots
