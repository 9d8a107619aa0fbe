#pragma once

#include "sim/state/frame.h"

namespace wry::render {

/// Whether a surface at rest is closed, each edge passed as often one way as the other, its triangles turned outwards.
/// Vertices at the same place count as one. Where the matter is given by tets, all of it together must enclose a
/// positive volume, so that a hollow may be turned inwards; otherwise each connected piece must.
bool is_closed_outward(const SceneBody& body);

/// Whether the matter lies the right way out on a frame: of tets none is inverted, without tets the body moves as a
/// whole and is not mirrored. Of a closed surface about such matter an eye outside meets the front of a triangle first,
/// so that back faces need not be drawn.
bool is_right_way_out(const SceneBody& body, const FrameBody& on_frame, const Eigen::Ref<const Points>& positions);

} // namespace wry::render
