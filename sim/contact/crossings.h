#pragma once

#include <array>
#include <vector>

#include "sim/base/parallel.h"
#include "sim/contact/surface.h"

namespace wry::contact {

/// An edge that cuts or touches a triangle.
struct Crossing {
  Surface::Edge edge;
  Surface::Triangle triangle;
};

/// All crossings of edges and triangles of parts that may meet, exactly (adaptive predicates; touching counts); stops
/// at about `limit`. Edges with a corner of the triangle are left out. Two surfaces that meet cross in such a pair, so
/// an empty answer proves that nothing intersects. Same answer on any number of threads.
std::vector<Crossing> find_crossings(const Surface& surface, const Points& positions, const Threads& threads,
                                     std::size_t limit = 100);

} // namespace wry::contact
