#pragma once

#include <string>
#include <vector>

#include "shots/shot.h"

namespace wry::shots {

/// What has to be done again when a value changes.
enum class Effect {
  simulation, ///< simulation and pictures
  pictures,   ///< pictures only
  nothing,    ///< neither: names, what is kept, measured or expected
};

struct FlatKey {
  std::string key;   ///< "body.bunny.resolution"
  std::string value; ///< canonical TOML; paths relative to the shot's folder
  Effect effect = Effect::nothing;
};

/// Every key of the shot with its value, defaults too, in the order of the schema. Two shots with equal lists are the
/// same shot. Materials and looks that no body uses affect nothing; of the frames only the first affects the simulation
/// ("shot.frames.first"). Asset contents are not in it: hash the files.
std::vector<FlatKey> flatten(const Shot& shot);

/// Keys that differ, for "what made the cache stale": values as "before -> after".
struct KeyChange {
  std::string key, before, after; ///< an absent key has an empty value
  Effect effect = Effect::nothing;
};
std::vector<KeyChange> compare(const std::vector<FlatKey>& before, const std::vector<FlatKey>& after);

/// The whole shot as TOML, defaults and presets written out, `extends` and sweep gone; load it from `directory` (where
/// it will be stored; empty: the shot's own folder) and flatten() is the same.
std::string write_resolved(const Shot& shot, const std::string& directory = "");

} // namespace wry::shots
