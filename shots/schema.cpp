#include "shots/schema.h"

#include <algorithm>

namespace wry::shots {

bool Interval::contains(double number) const {
  return (low_open ? number > low : number >= low) && (high_open ? number < high : number <= high);
}

std::string Interval::text() const {
  constexpr double UNBOUNDED = 1e9; // limits that only keep arithmetic finite are no news to a user
  const bool has_low = low > -UNBOUNDED, has_high = high < UNBOUNDED;
  if (has_low && has_high) {
    return fmt::format("{}{}, {}{}", low_open ? '(' : '[', low, high, high_open ? ')' : ']');
  }
  if (has_low) {
    return fmt::format("{} {}", low_open ? ">" : ">=", low);
  }
  return has_high ? fmt::format("{} {}", high_open ? "<" : "<=", high) : std::string();
}

Interval any_number() {
  return Interval{-1e15, 1e15, false, false};
}
Interval positive(double high) {
  return Interval{0.0, high, true, false};
}
Interval at_least_zero(double high) {
  return Interval{0.0, high, false, false};
}
Interval between(double low, double high) {
  return Interval{low, high, false, false};
}
Interval strictly_between(double low, double high) {
  return Interval{low, high, true, true};
}

Field Field::standard(Value data) const {
  Field field = *this;
  field.value = std::move(data);
  return field;
}
Field Field::default_is(std::string note) const {
  Field field = *this;
  field.default_note = std::move(note);
  return field;
}
Field Field::required() const {
  Field field = *this;
  field.is_required = true;
  return field;
}
Field Field::or_word(std::string word_, std::string note) const {
  Field field = *this;
  field.value = Value(word_);
  field.word = std::move(word_);
  field.default_note = std::move(note);
  return field;
}
Field Field::affects(Effect effect_) const {
  Field field = *this;
  field.effect = effect_;
  return field;
}
Field Field::called(std::string noun_) const {
  Field field = *this;
  field.noun = std::move(noun_);
  return field;
}
Field Field::or_per(std::vector<std::string> keys_, Interval range_) const {
  Field copy = *this;
  Section table;
  table.doc = doc;
  for (const std::string& name : keys_) {
    Field part = number(name, unit, range_, "Along " + name + ".").called(noun.empty() ? "number" : noun).required();
    table.fields.push_back(part);
  }
  copy.section = std::make_shared<const Section>(std::move(table));
  return copy;
}

Field Field::advice(std::string hint_) const {
  Field field = *this;
  field.hint = std::move(hint_);
  return field;
}

std::vector<std::string> Field::words() const {
  std::vector<std::string> words;
  for (const Choice& option : choices) {
    if (option.refusal.empty()) {
      words.push_back(option.word);
    }
  }
  return words;
}

const Field* Section::find(std::string_view key) const {
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const Field& field) { return field.key == key; });
  return found == fields.end() ? nullptr : &*found;
}

std::vector<std::string> Section::keys() const {
  std::vector<std::string> keys;
  for (const Field& field : fields) {
    keys.push_back(field.key);
  }
  return keys;
}

Field plain(std::string key, Kind kind, std::string doc) {
  Field field;
  field.key = std::move(key);
  field.kind = kind;
  field.doc = std::move(doc);
  return field;
}

Field boolean(std::string key, std::string doc) {
  return plain(std::move(key), Kind::boolean, std::move(doc));
}

Field integer(std::string key, Interval range, std::string doc) {
  Field field = plain(std::move(key), Kind::integer, std::move(doc));
  field.range = range;
  return field;
}

Field number(std::string key, std::string unit, Interval range, std::string doc) {
  Field field = plain(std::move(key), Kind::number, std::move(doc));
  field.unit = std::move(unit);
  field.range = range;
  return field;
}

Field choice(std::string key, std::vector<Choice> choices, std::string doc) {
  Field field = plain(std::move(key), Kind::choice, std::move(doc));
  field.choices = std::move(choices);
  return field;
}

Field word_list(std::string key, std::vector<Choice> choices, std::string doc) {
  Field field = plain(std::move(key), Kind::word_list, std::move(doc));
  field.choices = std::move(choices);
  return field;
}

Field numbers(std::string key, int length, std::string unit, Interval range, std::string doc) {
  Field field = plain(std::move(key), Kind::numbers, std::move(doc));
  field.length = length;
  field.unit = std::move(unit);
  field.range = range;
  return field;
}

Field integers(std::string key, int length, Interval range, std::string doc) {
  Field field = plain(std::move(key), Kind::integers, std::move(doc));
  field.length = length;
  field.range = range;
  return field;
}

Field reference(std::string key, std::string target, std::string doc) {
  Field field = plain(std::move(key), Kind::reference, std::move(doc));
  field.target = std::move(target);
  return field;
}

Field nested(std::string key, Kind kind, Section section, std::string doc) {
  Field field = plain(std::move(key), kind, std::move(doc));
  field.section = std::make_shared<const Section>(std::move(section));
  return field;
}

Value number_list(std::vector<double> list) {
  Array array;
  for (const double entry : list) {
    array.emplace_back(entry);
  }
  return Value(std::move(array));
}

Value text_list(std::vector<std::string> list) {
  Array array;
  for (std::string& entry : list) {
    array.emplace_back(std::move(entry));
  }
  return Value(std::move(array));
}

} // namespace wry::shots
