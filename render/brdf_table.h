#pragma once

#include <array>
#include <vector>

namespace wry::render {

/// Side of the table.
constexpr int BRDF_TABLE_SIZE = 32;

/// How much of the light from all around a GGX surface sends towards the eye, split as F0 * scale + bias (Karis 2013).
/// Row: roughness, column: cosine of the view angle, both from 0 to 1 at the centres of the outermost entries.
std::vector<std::array<float, 2>> make_brdf_table();

} // namespace wry::render
