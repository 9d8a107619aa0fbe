#pragma once

#include "render/drawable_scene.h"

namespace wry::render {

/// Small things that show what pictures of surfaces cannot: frames of the directors (red, green, blue for the local x,
/// y and z; from "microrotation" or "orientation"), rods along "fibre", and pins where "contact_force" acts. At most
/// `MARKS_MAX` of a body, always the same ones. Adds nothing for a body without the channel. Errors: bad_input for a
/// channel of the wrong shape.
Status append_signs(const SceneBody& body, const FrameBody& on_frame, const Points& positions, Signs signs, double size,
                    const Vec3& origin, std::uint32_t look_row, DrawCloud& marks);

/// The channel that a body would show, or nullptr.
const Channel* sign_channel(const FrameBody& on_frame, Signs signs);

constexpr std::size_t MARKS_MAX = 1200;

} // namespace wry::render
