#pragma once

#include "shots/tree.h"

namespace wry::shots {

/// The checked tree behind a Shot, every default in it.
struct ResolvedTree {
  Table root;
};

} // namespace wry::shots
