#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/base/result.h"

namespace wry::pipeline {

/// Looks for signs that a file was cut short or damaged which readers pass over in silence: OBJ faces that name missing
/// vertices or stop in the middle, STL, GLB and 3DS sizes against what their headers say, OFF counts against the lines
/// that follow. `extension` is in lower case without the dot; other formats pass. Suspicions go to `notes`. Errors:
/// bad_input with the line or the sizes.
Status check_file(std::string_view bytes, std::string_view extension, std::vector<std::string>& notes);

/// An OBJ text whose vertex and face lines end before their comments, which the reader behind us would take for
/// indices.
std::string without_trailing_comments(std::string obj);

} // namespace wry::pipeline
