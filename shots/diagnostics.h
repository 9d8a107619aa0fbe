#pragma once

#include <string>
#include <vector>

#include "shots/source.h"
#include "sim/base/result.h"

namespace wry::shots {

/// One thing that is wrong with a shot.
struct Diagnostic {
  Source source;
  std::string message; ///< what was found, what was expected, what to do
};

/// Collects what is wrong, so that a user sees it all at once.
class Diagnostics {
public:
  void add(Source source, std::string message);
  bool empty() const { return m_count == 0; }
  std::size_t count() const { return m_count; }
  /// No more will be shown: searching for suggestions is a waste.
  bool full() const;
  /// Whether something is wrong with this key or a key below it.
  bool any_under(const std::string& key) const;
  const std::vector<Diagnostic>& list() const { return m_list; }
  /// One line each in the order of the file, then how many were left out. Code bad_input.
  Error error() const;

private:
  std::vector<Diagnostic> m_list;
  std::size_t m_count = 0;
};

} // namespace wry::shots
