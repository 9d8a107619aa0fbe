#pragma once

#include "shots/shot.h"
#include "sim/scene/region.h"

namespace wry::pipeline {

/// `where` of the shot file as the scene understands it.
scene::Region compile_region(const shots::Region& region);

} // namespace wry::pipeline
