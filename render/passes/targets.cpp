#include "render/passes/pass.h"

#include <algorithm>

namespace wry::render {

namespace {

bool may_be_transparent(const RenderPlan& plan) {
  return plan.default_look.transparency > 0.f ||
         std::any_of(plan.looks.begin(), plan.looks.end(),
                     [](const auto& look) { return look.second.transparency > 0.f; });
}

} // namespace

Result<Targets> make_targets(const GlFunctions& gl, const RenderPlan& plan) {
  const ImageSize& size = plan.size;
  GLint side_max = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &side_max);
  if (size.width > side_max || size.height > side_max)
    return make_error(ErrorCode::bad_input, "a picture of {} x {} pixels: this OpenGL draws at most {} on a side",
                      size.width, size.height, side_max);
  Targets targets;
  targets.size = size;
  targets.half_size = {(size.width + 1) / 2, (size.height + 1) / 2};
  targets.surface = make_texture(gl, GL_RG32UI, size.width, size.height, TextureFilter::nearest);
  targets.depth = make_texture(gl, GL_DEPTH_COMPONENT32F, size.width, size.height, TextureFilter::nearest);
  targets.shadow =
      make_texture(gl, GL_DEPTH_COMPONENT32F, SHADOW_MAP_SIZE, SHADOW_MAP_SIZE, TextureFilter::shadow_compare);
  targets.occlusion = make_texture(gl, GL_RGBA8, size.width, size.height, TextureFilter::nearest);
  // Half floats round each of many small shares; a few they hold well enough, at half the cost.
  const GLenum sum_format = plan.samples > 16 ? GL_RGBA32F : GL_RGBA16F;
  targets.accumulation = make_texture(gl, sum_format, size.width, size.height, TextureFilter::nearest);
  if (may_be_transparent(plan))
    targets.light = make_texture(gl, GL_RGBA16F, size.width, size.height, TextureFilter::nearest);
  targets.display =
      make_texture(gl, plan.bits == 16 ? GL_RGBA16 : GL_RGBA8, size.width, size.height, TextureFilter::nearest);
  if (gl.GetError() != GL_NO_ERROR)
    return make_error(ErrorCode::out_of_memory, "no memory for the layers of a picture of {} x {} pixels", size.width,
                      size.height);
  const auto attach = [&](GlObject& frame, const GlObject* color, const GlObject* depth) -> Status {
    Result<GlObject> made =
        make_framebuffer(gl, color != nullptr ? color->name() : 0, depth != nullptr ? depth->name() : 0);
    if (!made.ok())
      return made.error();
    frame = std::move(*made);
    return {};
  };
  if (targets.light.name() != 0) {
    if (const Status status = attach(targets.light_frame, &targets.light, &targets.depth); !status.ok())
      return status.error();
  }
  for (const Status& status : {attach(targets.surface_frame, &targets.surface, &targets.depth),
                               attach(targets.shadow_frame, nullptr, &targets.shadow),
                               attach(targets.accumulation_frame, &targets.accumulation, &targets.depth),
                               attach(targets.display_frame, &targets.display, nullptr)}) {
    if (!status.ok())
      return status.error();
  }
  return targets;
}

void draw_in_rect(const GlFunctions& gl, const PixelRect& rect) {
  if (rect.width <= 0 || rect.height <= 0)
    return;
  gl.Enable(GL_SCISSOR_TEST);
  gl.Scissor(rect.x, rect.y, rect.width, rect.height);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  gl.Disable(GL_SCISSOR_TEST);
}

} // namespace wry::render
