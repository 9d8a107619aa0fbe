#pragma once

#include <memory>
#include <span>
#include <vector>

#include "render/drawable_scene.h"
#include "render/gl/gl_objects.h"
#include "render/passes/light_state.h"
#include "render/passes/touched_rect.h"

namespace wry::render {

/// Side of the key light's shadow map [texels].
constexpr int SHADOW_MAP_SIZE = 2048;
/// How far ambient occlusion looks, as a part of the radius of the bounds.
constexpr double OCCLUSION_REACH = 0.30;

/// What the passes draw into and read from.
struct Targets {
  ImageSize size;
  ImageSize half_size;
  GlObject surface;      ///< RG32UI: look, wire and heat; octahedral normal. Look 0 is nothing, so rows count from 1
  GlObject depth;        ///< near_distance / distance along the view axis; 0 is nothing
  GlObject shadow;       ///< the key light's depth map of this sub-frame
  GlObject occlusion;    ///< RGBA8: ambient visibility, distance of blockers of the key light, share of blockers
  GlObject accumulation; ///< sum of the sub-frames' linear light, and of coverage
  GlObject display;      ///< RGBA8
  GlObject surface_frame;
  GlObject shadow_frame;
  GlObject accumulation_frame;
  GlObject display_frame;
};

/// Errors: unavailable, or out_of_memory when the size is beyond what OpenGL gives.
Result<Targets> make_targets(const GlFunctions& gl, const ImageSize& size);

/// The triangles of the current picture on the graphics side.
class Geometry {
public:
  explicit Geometry(const GlFunctions& gl);
  void upload(const DrawList& list);
  void draw() const;

private:
  const GlFunctions& m_gl;
  GlObject m_vertices;
  GlObject m_indices;
  GlObject m_array;
  GLsizei m_count = 0;
  bool m_indexed = false;
};

/// One of the jittered pictures whose mean is the picture.
struct SubFrame {
  int index = 0;
  int count = 1;
  const View* view = nullptr;
  Camera camera;          ///< relative to the centre of the bounds
  Eigen::Vector2f jitter; ///< shift of the picture [ndc]
  Eigen::Matrix4f clip_from_world;
  float scene_radius = 1.f;  ///< [m]
  float ground_height = 0.f; ///< along up, relative to the centre of the bounds [m]
  PixelRect touched;         ///< outside it the picture is evenly lit floor and backdrop
  LightState lights;
};

struct PassResources {
  const GlFunctions& gl;
  const RenderPlan& plan;
  const std::vector<Look>& looks;
  const Targets& targets;
  const Geometry& geometry;
};

class Pass {
public:
  virtual ~Pass() = default;
  virtual void draw(const SubFrame& sub_frame) = 0;
};

/// When a pass runs.
enum class PassRate { sub_frame, first_sub_frame, last_sub_frame };

/// One line of the table of passes, drawn in the table's order.
struct PassEntry {
  const char* name;
  PassRate rate;
  /// Whether a view by this plan needs the pass at all.
  bool (*needed)(const RenderPlan& plan, const View& view);
  Result<std::unique_ptr<Pass>> (*create)(const PassResources& resources);
};

std::span<const PassEntry> pass_table();

/// Draws the full-screen triangle of the current program, within the rectangle.
void draw_in_rect(const GlFunctions& gl, const PixelRect& rect);

Result<std::unique_ptr<Pass>> create_shadow_pass(const PassResources& resources);
Result<std::unique_ptr<Pass>> create_surface_pass(const PassResources& resources);
Result<std::unique_ptr<Pass>> create_occlusion_pass(const PassResources& resources);
Result<std::unique_ptr<Pass>> create_light_pass(const PassResources& resources);
Result<std::unique_ptr<Pass>> create_tone_pass(const PassResources& resources);

} // namespace wry::render
