#pragma once

#include <string>
#include <utility>

namespace wry::shots {

/// Who asked for a value.
enum class Origin {
  standard,     ///< nobody: the default of the schema
  preset,       ///< the material's preset
  file,         ///< the shot file, or one that it extends
  command_line, ///< --set, or a wedge of the sweep
};

/// Where a value comes from.
struct Source {
  std::string file; ///< as named by the user; "--set" for the command line, "preset rubber" for a preset
  int line = 0;     ///< from 1; 0: the value stands in no file
  int column = 0;   ///< from 1, in characters
  std::string key;  ///< the whole key, array tables by name: "body.bunny.resolution"
  Origin origin = Origin::standard;

  /// Whether somebody asked for it, rather than the default.
  bool given() const { return origin != Origin::standard; }
  /// "bunny.toml:12:8: body.bunny.resolution" for messages; without a line where there is none.
  std::string text() const;
};

/// A value and where it was asked for.
template <class T> struct Located {
  T value{};
  Source source;

  Located() = default;
  Located(T v, Source s = {})
      : value(std::move(v))
      , source(std::move(s)) {}

  const T& operator*() const { return value; }
  const T* operator->() const { return &value; }
  bool given() const { return source.given(); }
};

} // namespace wry::shots
