#pragma once

#include "render/passes/pass.h"

namespace wry::render {

/// GLSL that several passes share: constants, the pixel's ray, octahedral normals, noise. Follows "#version".
extern const char* const CAMERA_PART;
/// GLSL of the key light's shadow space. Follows CAMERA_PART.
extern const char* const SHADOW_SPACE_PART;

/// Sets the uniforms of CAMERA_PART. `size`: of the target that is drawn into [pixels].
void set_camera_part(const Program& program, const SubFrame& sub_frame, const RenderPlan& plan, const ImageSize& size);

/// Sets the uniforms of SHADOW_SPACE_PART.
void set_shadow_space_part(const Program& program, const LightState& lights);

} // namespace wry::render
