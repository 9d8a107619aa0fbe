#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shots/sweep.h"
#include "sim/base/result.h"

namespace wry::pipeline {

/// One value that a variant gives a key of the shot.
struct Parameter {
  std::string key;   ///< "material.skin.length_scale"; "case" names a case of [sweep]
  std::string value; ///< TOML
};

/// One member of a study: the shot with some values, with a number that stays its own as the study grows.
struct Variant {
  int index = 0;
  std::string hash; ///< 8 hexadecimal digits of the parameters
  std::string name; ///< for people
  std::vector<Parameter> parameters;

  std::string id() const;       ///< "003-1f0c9a2b", the folder's name
  std::string identity() const; ///< all parameters as text; equal variants have equal ones
  /// Words for the command line: --case and --set.
  std::vector<std::string> arguments() const;
};

/// A variant from a wedge of [sweep]; its index is not set yet.
Variant variant_of(const shots::Wedge& wedge);
/// A variant with these parameters, hashed; its index is not set yet.
Variant make_variant(std::string name, std::vector<Parameter> parameters);

/// Gives every variant its number: those that the study's register (variants.json in its folder) knows keep theirs, new
/// ones take the next free ones, and the register remembers them all. Variants that are no longer asked for keep their
/// number reserved. Errors: bad_input when the register is damaged or two different variants share a hash;
/// cannot_write, io.
Status number_variants(std::vector<Variant>& variants, const std::filesystem::path& folder);

/// A value as a person writes it: text without its quotes.
std::string plain_value(const std::string& value);

} // namespace wry::pipeline
