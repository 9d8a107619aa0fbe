#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "shots/check.h"
#include "shots/nearest.h"

namespace wry::shots {
namespace {

constexpr std::size_t LONGEST_NAME = 64, LONGEST_TEXT = 1024, LONGEST_PATH = 4096;

bool has_control_characters(std::string_view text) {
  return std::any_of(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 || byte == 0x7f;
  });
}

/// Checks one value; each kind is a member that returns what is stored or refuses.
class ValueChecker {
public:
  ValueChecker(const Field& field, const Value& value, const std::string& key, const KnownNames& names,
               const PathBase& paths, Diagnostics& diagnostics)
      : m_field(field)
      , m_value(value)
      , m_key(key)
      , m_names(names)
      , m_paths(paths)
      , m_diagnostics(diagnostics) {}

  std::optional<Value> check() {
    if (!m_field.word.empty() && text() == m_field.word) {
      return stored(m_field.word);
    }
    switch (m_field.kind) {
    case Kind::boolean:
      return m_value.get<bool>() ? std::optional(m_value) : mistyped();
    case Kind::integer:
      return integer(m_value);
    case Kind::number:
      return number(m_value);
    case Kind::choice:
      return choice();
    case Kind::word_list:
    case Kind::view_list:
      return words();
    case Kind::name:
      return name();
    case Kind::reference:
      return reference();
    case Kind::text:
      return short_text();
    case Kind::path:
      return path();
    case Kind::frames:
      return frames();
    case Kind::expression:
      return expression();
    case Kind::numbers:
    case Kind::integers:
      return list(m_value, m_field.length);
    case Kind::colour:
      return colour();
    case Kind::direction:
      return direction();
    case Kind::matrix:
      return matrix();
    default:
      return mistyped();
    }
  }

private:
  template <class T> std::optional<Value> stored(T data) const { return Value(std::move(data), m_value.place); }

  /// Text, or what stood on the command line when TOML read it as something else.
  std::optional<std::string> text() const {
    if (const auto* string = m_value.get<std::string>()) {
      return *string;
    }
    return m_value.raw.empty() ? std::nullopt : std::optional(m_value.raw);
  }

  std::optional<Value> refuse(const Value& value, const std::string& reason) {
    m_diagnostics.add(value.place.source(m_key), fmt::format(" = {}: {}", excerpt(value), reason));
    return std::nullopt;
  }

  std::optional<Value> out_of_range(const Value& value) {
    return refuse(value, "expected " + expectation(m_field) + (m_field.hint.empty() ? "" : "; " + m_field.hint));
  }

  std::optional<Value> mistyped() { return mistyped(m_value); }
  std::optional<Value> mistyped(const Value& value) {
    const auto* quoted = value.get<std::string>();
    const bool numeric = m_field.kind == Kind::number || m_field.kind == Kind::integer || m_field.kind == Kind::boolean;
    const bool remove_quotes = quoted && numeric && value.raw.empty();
    return refuse(value, fmt::format("this is {}; expected {}{}", describe_type(value), expectation(m_field),
                                     remove_quotes ? ", without quotes" : ""));
  }

  std::optional<Value> number(const Value& value) {
    if (!value.is_number()) {
      return mistyped(value);
    }
    const double found = value.number();
    if (!std::isfinite(found) || !m_field.range.contains(found)) {
      return out_of_range(value);
    }
    // No negative zero: equal shots are to have equal text.
    return Value(found == 0.0 ? 0.0 : found, value.place);
  }

  std::optional<Value> integer(const Value& value) {
    if (const auto* found = value.get<std::int64_t>()) {
      return m_field.range.contains(static_cast<double>(*found)) ? std::optional(Value(*found, value.place))
                                                                 : out_of_range(value);
    }
    const auto* floating = value.get<double>();
    if (!floating) {
      return mistyped(value);
    }
    if (!std::isfinite(*floating) || *floating != std::floor(*floating) || !m_field.range.contains(*floating)) {
      return out_of_range(value);
    }
    return Value(static_cast<std::int64_t>(*floating), value.place);
  }

  std::optional<Value> list(const Value& value, int length) {
    const auto* array = value.get<Array>();
    if (!array || array->size() != static_cast<std::size_t>(length)) {
      return mistyped(value);
    }
    Array checked;
    for (const Value& entry : *array) {
      std::optional<Value> item = m_field.kind == Kind::integers ? integer(entry) : number(entry);
      if (!item) {
        return std::nullopt;
      }
      checked.push_back(std::move(*item));
    }
    return Value(std::move(checked), value.place);
  }

  std::optional<Value> choice() {
    const std::optional<std::string> word = text();
    return word ? one_word(m_value, *word) : mistyped();
  }

  std::optional<Value> one_word(const Value& value, const std::string& word) {
    for (const Choice& option : m_field.choices) {
      if (option.word == word) {
        return option.refusal.empty() ? std::optional(Value(word, value.place))
                                      : refuse(value, fmt::format("this build has no {} yet; use one of {}",
                                                                  option.refusal, fmt::join(m_field.words(), ", ")));
      }
    }
    return refuse(value, "expected " + expectation(m_field) + near(word, m_field.words()));
  }

  static std::string near(const std::string& word, const std::vector<std::string>& candidates) {
    const std::string best = nearest(word, candidates);
    return best.empty() ? std::string() : fmt::format("; did you mean '{}'?", best);
  }

  std::optional<Value> words() {
    Array array;
    if (const auto* given = m_value.get<Array>()) {
      array = *given;
    } else if (m_value.get<std::string>()) {
      array = {m_value}; // one word may stand without brackets
    } else {
      return mistyped();
    }
    if (array.empty() || array.size() > 64) {
      return mistyped();
    }
    std::set<std::string> seen;
    for (Value& item : array) {
      const auto* word = item.get<std::string>();
      if (!word) {
        return mistyped(item);
      }
      if (!(m_field.kind == Kind::view_list ? view(item, *word) : one_word(item, *word).has_value())) {
        return std::nullopt;
      }
      if (!seen.insert(*word).second) {
        return refuse(item, "listed twice");
      }
      item = Value(std::string(*word), item.place);
    }
    return stored(std::move(array));
  }

  bool view(const Value& item, const std::string& word) {
    const bool heat = word.compare(0, 5, "heat.") == 0 && is_safe_name(std::string_view(word).substr(5), Dots::refused);
    const std::vector<std::string> words = {"beauty", "clay", "wire", "directors", "fibres", "contacts"};
    if (heat || std::find(words.begin(), words.end(), word) != words.end()) {
      return true;
    }
    std::vector<std::string> nearest_of = words;
    nearest_of.push_back("heat.speed");
    refuse(item, fmt::format("expected {} or heat.<channel>", fmt::join(words, ", ")) + near(word, nearest_of));
    return false;
  }

  std::optional<Value> name() {
    const std::optional<std::string> word = text();
    if (!word) {
      return mistyped();
    }
    const bool of_shot = m_key == "shot.name";
    if (!is_safe_name(*word, of_shot ? Dots::allowed : Dots::refused)) {
      return refuse(m_value, fmt::format("expected at most {} letters, digits, _ and -{}; it becomes part of {}",
                                         LONGEST_NAME, of_shot ? ", with dots only inside" : "",
                                         of_shot ? "file names" : "keys and file names"));
    }
    return stored(*word);
  }

  std::optional<Value> reference() {
    const std::optional<std::string> word = text();
    if (!word) {
      return mistyped();
    }
    const auto known = m_names.find(m_field.target);
    const std::vector<std::string> names = known == m_names.end() ? std::vector<std::string>{} : known->second;
    if (std::find(names.begin(), names.end(), *word) == names.end()) {
      const bool listed = m_field.target == "body" || m_field.target == "measure" || m_field.target == "sweep.case";
      const std::string what = listed ? fmt::format("[[{}]] with this name", m_field.target)
                                      : fmt::format("[{}.{}]", m_field.target, excerpt(*word));
      return refuse(m_value, fmt::format("there is no {}{}", what, suggestion(*word, names)));
    }
    return stored(*word);
  }

  std::optional<Value> short_text() {
    const std::optional<std::string> found = text();
    if (!found) {
      return mistyped();
    }
    if (found->empty() || found->size() > LONGEST_TEXT || has_control_characters(*found)) {
      return refuse(m_value, fmt::format("expected 1 to {} printable characters", LONGEST_TEXT));
    }
    return stored(*found);
  }

  std::optional<Value> path() {
    const std::optional<std::string> found = text();
    if (!found) {
      return mistyped();
    }
    if (found->empty() || found->size() > LONGEST_PATH || has_control_characters(*found)) {
      return refuse(m_value, fmt::format("expected the path of a file, 1 to {} printable characters", LONGEST_PATH));
    }
    return stored(rebase(*found));
  }

  /// A path of another file, expressed from the main file's folder.
  std::string rebase(const std::string& found) const {
    namespace fs = std::filesystem;
    const fs::path path(found);
    const bool elsewhere = m_value.place.origin == Origin::file && m_value.place.file &&
                           *m_value.place.file != m_paths.main_file && path.is_relative();
    if (!elsewhere) {
      return path.lexically_normal().generic_string();
    }
    const fs::path from = fs::path(*m_value.place.file).parent_path() / path;
    const fs::path relative =
        from.lexically_normal().lexically_relative(fs::path(m_paths.directory).lexically_normal());
    std::error_code ignored;
    return (relative.empty() ? fs::absolute(from, ignored).lexically_normal() : relative).generic_string();
  }

  std::optional<Value> frames() {
    std::optional<std::string> found = text();
    if (const auto* single = m_value.get<std::int64_t>()) {
      found = fmt::format("{}", *single);
    }
    if (!found) {
      return mistyped();
    }
    const Result<FrameRange> range = FrameRange::parse(*found);
    if (!range) {
      return refuse(m_value, range.error().message);
    }
    return stored(range->text());
  }

  std::optional<Value> expression() {
    if (m_value.is_number()) {
      return number(m_value);
    }
    return m_value.get<std::string>() ? short_text() : mistyped();
  }

  std::optional<Value> colour() {
    const auto* hex = m_value.get<std::string>();
    if (!hex) {
      Field triple = m_field;
      triple.range = between(0.0, 1.0);
      triple.length = 3;
      return ValueChecker(triple, m_value, m_key, m_names, m_paths, m_diagnostics).list(m_value, 3);
    }
    const bool well_formed = hex->size() == 7 && hex->front() == '#' &&
                             hex->find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
    if (!well_formed) {
      return out_of_range(m_value);
    }
    std::vector<double> channels;
    for (const int at : {1, 3, 5}) {
      channels.push_back(std::stoi(hex->substr(at, 2), nullptr, 16) / 255.0);
    }
    Value list = number_list(channels);
    list.place = m_value.place;
    return list;
  }

  std::optional<Value> direction() {
    if (const auto* word = m_value.get<std::string>()) {
      const bool negative = !word->empty() && word->front() == '-';
      const auto axis = std::string_view("xyz").find(word->substr(negative ? 1 : 0));
      if (word->size() != (negative ? 2u : 1u) || axis == std::string_view::npos) {
        return out_of_range(m_value);
      }
      std::vector<double> vector(3, 0.0);
      vector[axis] = negative ? -1.0 : 1.0;
      Value list = number_list(vector);
      list.place = m_value.place;
      return list;
    }
    Field vector = m_field;
    vector.range = any_number();
    std::optional<Value> found = ValueChecker(vector, m_value, m_key, m_names, m_paths, m_diagnostics).list(m_value, 3);
    if (found) {
      double square = 0.0;
      for (const Value& entry : *found->get<Array>()) {
        square += entry.number() * entry.number();
      }
      if (square < 1e-18) {
        return refuse(m_value, "a direction of no length; expected " + expectation(m_field));
      }
    }
    return found;
  }

  std::optional<Value> matrix() {
    const auto* rows = m_value.get<Array>();
    if (!rows || rows->size() != 3) {
      return mistyped();
    }
    Array checked;
    for (const Value& row : *rows) {
      std::optional<Value> found = list(row, 3);
      if (!found) {
        return std::nullopt;
      }
      checked.push_back(std::move(*found));
    }
    return stored(std::move(checked));
  }

  const Field& m_field;
  const Value& m_value;
  const std::string& m_key;
  const KnownNames& m_names;
  const PathBase& m_paths;
  Diagnostics& m_diagnostics;
};

} // namespace

std::optional<Value> check_value(const Field& field, const Value& value, const std::string& key,
                                 const KnownNames& names, const PathBase& paths, Diagnostics& diagnostics) {
  return ValueChecker(field, value, key, names, paths, diagnostics).check();
}

bool is_safe_name(std::string_view name, Dots dots) {
  if (name.empty() || name.size() > LONGEST_NAME || name.front() == '-' || name.front() == '.' || name.back() == '.') {
    return false;
  }
  return std::all_of(name.begin(), name.end(), [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           (c == '.' && dots == Dots::allowed);
  });
}

} // namespace wry::shots
