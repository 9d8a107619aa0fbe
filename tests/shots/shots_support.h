#pragma once

#include <string>

#include <gmock/gmock.h>

#include "shots/load.h"

namespace wry::shots {

/// A small shot that is right; tests break or extend it.
inline const char* const SMALL_SHOT = R"([shot]
name = "small"

[[body]]
name = "block"
box = { size = [1, 1, 1] }
resolution = 0.1
material = "skin"

[material.skin]
model = "micropolar"
youngs_modulus = 5e4
poisson_ratio = 0.4
)";

inline std::string data_file(const std::string& name) {
  return std::string(WRY_TEST_DATA) + "/shots/" + name;
}

inline Result<Shot> load_text(const std::string& text, const std::vector<Override>& overrides = {}) {
  const Result<ShotDocument> document = read_document_text(text, "t.toml", ".");
  if (!document) {
    return document.error();
  }
  const Result<ShotDocument> changed = apply_overrides(*document, overrides);
  return changed ? make_shot(*changed) : Result<Shot>(changed.error());
}

/// SMALL_SHOT with more text behind it.
inline Result<Shot> load_with(const std::string& more, const std::vector<Override>& overrides = {}) {
  return load_text(SMALL_SHOT + more, overrides);
}

/// The message of a shot that has to be refused; "accepted" when it was not.
inline std::string refusal(const Result<Shot>& shot) {
  return shot ? std::string("accepted") : shot.error().message;
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "no '" << from << "' to replace";
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

} // namespace wry::shots
