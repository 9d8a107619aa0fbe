#include <fmt/ranges.h>

#include "shots/check.h"

namespace wry::shots {
namespace {

std::string with_article(const std::string& noun) {
  const bool vowel = std::string_view("aeiou").find(noun.front()) != std::string_view::npos;
  return (vowel ? "an " : "a ") + noun;
}

std::string in_unit(const Field& field) {
  return field.unit.empty() || field.unit == "degrees" ? (field.unit.empty() ? "" : " in degrees")
                                                       : " in " + field.unit;
}

std::string expect_number(const Field& field) {
  const std::string noun = field.noun.empty() ? "number" : field.noun;
  const std::string range = field.range.text();
  std::string text = range == "> 0" ? "a positive " + noun : with_article(noun);
  if (!range.empty() && range != "> 0") {
    text += (range.front() == '(' || range.front() == '[' ? " in " : " ") + range;
  }
  return text + in_unit(field);
}

std::string expect_integer(const Field& field) {
  const std::string range = field.range.text();
  return "an integer" +
         (range.empty() ? std::string() : fmt::format(" {}{}", range.front() == '[' ? "in " : "", range));
}

std::string expect_list(const Field& field) {
  const std::string range = field.range.text();
  const std::string noun = field.kind == Kind::integers ? "integers" : field.noun.empty() ? "numbers" : field.noun;
  const std::string bounds = range == "> 0" ? " positive" : range.empty() || range[0] == '[' ? "" : " " + range;
  return fmt::format("a list of {}{} {}{}{}", field.length, bounds, noun, range[0] == '[' ? " in " + range : "",
                     in_unit(field));
}

std::string expect_plain(const Field& field) {
  switch (field.kind) {
  case Kind::boolean:
    return "true or false";
  case Kind::integer:
    return expect_integer(field);
  case Kind::number:
    return expect_number(field);
  case Kind::choice:
    return fmt::format("one of {}", fmt::join(field.words(), ", "));
  case Kind::word_list:
    return fmt::format("a list of some of {}", fmt::join(field.words(), ", "));
  case Kind::name:
    return "a name of letters, digits, _ and -";
  case Kind::reference:
    return field.target.find('.') == std::string::npos ? "the name of a " + field.target : "the name of a sweep case";
  case Kind::view_list:
    return "a list of views: beauty, clay, wire, heat.<channel>, directors, fibres, contacts";
  case Kind::text:
    return "a short text";
  case Kind::path:
    return "the path of a file";
  case Kind::frames:
    return "frames such as \"1-120\" or \"1001-1100x2,1150\"";
  case Kind::expression:
    return "a number or a formula in quotes" + in_unit(field);
  case Kind::numbers:
  case Kind::integers:
    return expect_list(field);
  case Kind::colour:
    return "a colour, [r, g, b] in 0..1 or \"#rrggbb\"";
  case Kind::direction:
    return "an axis: \"x\", \"y\", \"z\", \"-x\", ... or a list of 3 numbers that are not all 0";
  case Kind::matrix:
    return "three lists of 3 numbers";
  case Kind::table:
    return "a table { ... } with " + fmt::format("{}", fmt::join(field.section->keys(), ", "));
  case Kind::table_list:
    return "a table { ... } or a list of tables with " + fmt::format("{}", fmt::join(field.section->keys(), ", "));
  case Kind::named_list:
    return fmt::format("tables written [[{}]], each with a name", field.key);
  case Kind::named_tables:
    return fmt::format("tables written [{}.<name>]", field.key);
  case Kind::free:
    return "a table";
  }
  return {};
}

} // namespace

std::string expectation(const Field& field) {
  return expect_plain(field) + (field.word.empty() ? "" : fmt::format(" or \"{}\"", field.word));
}

} // namespace wry::shots
