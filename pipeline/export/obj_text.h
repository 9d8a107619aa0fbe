#pragma once

#include <string>

#include "sim/base/types.h"

namespace wry::pipeline {

/// A mesh as the text of an OBJ file, with digits that read back the same floats.
std::string obj_text(const std::string& name, const Points& positions, const Triangles& triangles);

} // namespace wry::pipeline
