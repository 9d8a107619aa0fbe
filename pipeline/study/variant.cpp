#include "pipeline/study/variant.h"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cache/sha256.h"

namespace wry::pipeline {

namespace {

using nlohmann::json;

constexpr const char* REGISTER = "variants.json";

struct Known {
  int index = 0;
  std::string hash, name, identity;
};

Result<std::vector<Known>> read_register(const std::filesystem::path& path) {
  std::vector<Known> known;
  if (!std::filesystem::exists(path))
    return known;
  const Result<std::string> text = read_whole_file(path);
  if (!text)
    return text.error();
  try {
    for (const json& entry : json::parse(*text))
      known.push_back({entry.at("index"), entry.at("hash"), entry.at("name"), entry.at("parameters")});
  } catch (const json::exception& problem) {
    return make_error(ErrorCode::bad_input,
                      "{}: this is no register of variants ({}); move it away to number the study anew", path.string(),
                      problem.what());
  }
  return known;
}

Status write_register(const std::filesystem::path& path, const std::vector<Known>& known) {
  json list = json::array();
  for (const Known& entry : known)
    list.push_back(
        {{"index", entry.index}, {"hash", entry.hash}, {"name", entry.name}, {"parameters", entry.identity}});
  return write_file_atomically(path, list.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
}

} // namespace

std::string Variant::id() const {
  return fmt::format("{:03}-{}", index, hash);
}

std::string Variant::identity() const {
  std::string text;
  for (const Parameter& parameter : parameters)
    text += parameter.key + "=" + parameter.value + "\n";
  return text;
}

std::vector<std::string> Variant::arguments() const {
  std::vector<std::string> words;
  for (const Parameter& parameter : parameters) {
    if (parameter.key == "case")
      words.insert(words.end(), {"--case", parameter.value});
    else
      words.insert(words.end(), {"--set", parameter.key + "=" + parameter.value});
  }
  return words;
}

Variant variant_of(const shots::Wedge& wedge) {
  Variant variant{0, wedge.hash, wedge.name, {}};
  for (const shots::Override& override_ : wedge.overrides)
    variant.parameters.push_back({override_.key, override_.value});
  return variant;
}

Variant make_variant(std::string name, std::vector<Parameter> parameters) {
  Variant variant{0, {}, std::move(name), std::move(parameters)};
  variant.hash = sha256_of_bytes(variant.identity()).substr(0, 8);
  return variant;
}

Status number_variants(std::vector<Variant>& variants, const std::filesystem::path& folder) {
  Result<std::vector<Known>> read = read_register(folder / REGISTER);
  if (!read)
    return read.error();
  std::vector<Known> known = std::move(*read);
  std::map<std::string, std::size_t> places;
  int next = 0;
  for (std::size_t i = 0; i < known.size(); ++i) {
    places[known[i].hash] = i;
    next = std::max(next, known[i].index + 1);
  }
  const std::size_t before = known.size();
  std::set<std::string> asked;
  for (Variant& variant : variants) {
    if (!asked.insert(variant.hash).second)
      return make_error(ErrorCode::bad_input, "{}: two variants have the same parameters; remove one", variant.name);
    const auto place = places.find(variant.hash);
    if (place == places.end()) {
      variant.index = next++;
      places[variant.hash] = known.size();
      known.push_back({variant.index, variant.hash, variant.name, variant.identity()});
      continue;
    }
    // A named case may be edited: its hash holds its values, its parameters only its name.
    variant.index = known[place->second].index;
    if (known[place->second].identity != variant.identity())
      return make_error(ErrorCode::bad_input, "{} and {} have the same hash {}; change a digit of one of their values",
                        known[place->second].name, variant.name, variant.hash);
  }
  if (known.size() == before)
    return {};
  if (Status status = prepare_folder(folder); !status)
    return status;
  return write_register(folder / REGISTER, known);
}

std::string plain_value(const std::string& value) {
  if (value.size() >= 2 && (value.front() == '"' || value.front() == '\'') && value.back() == value.front())
    return value.substr(1, value.size() - 2);
  const bool whole =
      value.size() > 2 && value.ends_with(".0") && value.find_first_not_of("-0123456789") == value.size() - 2;
  return whole ? value.substr(0, value.size() - 2) : value;
}

} // namespace wry::pipeline
