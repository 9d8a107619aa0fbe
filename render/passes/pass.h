#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "render/drawable_scene.h"
#include "render/gl/gl_objects.h"
#include "render/grain_shapes.h"
#include "render/hidden_grains.h"
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
  GlObject light;        ///< this sub-frame's alone, where bodies are transparent; else absent
  GlObject accumulation; ///< sum of the sub-frames' linear light, and of coverage
  GlObject display;      ///< RGBA8 or RGBA16
  GlObject surface_frame;
  GlObject shadow_frame;
  GlObject light_frame;
  GlObject accumulation_frame;
  GlObject display_frame;
};

/// Errors: unavailable, or out_of_memory when the size is beyond what OpenGL gives.
Result<Targets> make_targets(const GlFunctions& gl, const RenderPlan& plan);

/// The triangles and grains of the current picture on the graphics side.
class Geometry {
public:
  Geometry(const GlFunctions& gl, const std::vector<Image>& textures);
  void upload(DrawList&& list);
  bool has_triangles() const { return m_count > 0; }
  /// All triangles that are not transparent, without the back faces of closed surfaces; draw_textured() through `bind`
  /// for each run of one picture (0: none).
  void draw() const;
  void draw_clear() const; ///< the transparent ones
  bool has_clear() const { return m_clear_count > 0; }
  void draw_textured(const std::function<void(GLuint)>& bind) const;
  bool is_textured() const { return !m_ranges.empty(); }

  /// Grains as seen from the eye and from the key light. Call both before a sub-frame's passes; what has not moved is
  /// kept.
  void face_eye(const Eigen::Vector3f& eye, float seconds);
  void face_light(const Eigen::Vector3f& towards, float seconds);
  bool has_clouds() const { return !m_clouds.empty(); }
  std::size_t grains() const;
  /// Until the next upload(), show_rest() or show_seen() only those grains are drawn that are about the first the eye
  /// meets.
  void show_first_met(const Eigen::Matrix4f& clip_from_world, const ImageSize& size);
  /// Of the rest those that what was just drawn does not hide.
  void show_rest(const HidingPicture& drawn);
  /// All but the grains that what was just drawn hides. Like show_rest(): only where neither eye nor grains move.
  void show_seen(const HidingPicture& drawn);
  /// Gives the grains, as they face the eye, their velocity and body, for the data pass.
  void attach_grain_data();
  void draw_boxes() const;    ///< normals flat, from the last vertex
  void draw_rounds() const;   ///< normals smooth
  void draw_outlines() const; ///< for the shadow map: positions alone
  /// The corners of the outlines, OUTLINE_VERTICES each, and some of them, by number, in place of all.
  std::span<const std::array<float, 3>> outlines() const { return m_outline_vertices; }
  void draw_outlines(std::span<const std::uint32_t> chosen) const;

private:
  void upload_triangles(const DrawList& list);
  /// The pattern of one shape over and over, as long as `count` shapes need it.
  void grow_pattern(const GlObject& buffer, std::span<const std::uint32_t> pattern, std::uint32_t vertices,
                    std::size_t count, std::size_t& held);

  const GlFunctions& m_gl;
  GlObject m_vertices, m_indices, m_velocities, m_uvs, m_array;
  void draw_corners(std::size_t begin, std::size_t end) const;
  void draw_outward() const;

  GLsizei m_count = 0, m_outward_count = 0, m_clear_count = 0;
  bool m_indexed = false;
  std::vector<GlObject> m_textures;
  std::vector<TexturedRange> m_ranges;

  std::vector<DrawCloud> m_clouds;
  enum class Place : std::uint8_t { waiting, shown, hidden };
  std::vector<std::vector<Place>> m_places;       ///< per cloud and grain; empty: all are waiting
  std::vector<std::vector<DrawGrain>> m_in_sight; ///< per cloud, in place of its grains; empty: all are
  GlObject m_boxes, m_box_indices, m_box_array;
  GlObject m_rounds, m_round_indices, m_round_array;
  GlObject m_box_data, m_round_data;
  GlObject m_outlines, m_outline_indices, m_outline_array, m_chosen_indices;
  GLsizei m_box_count = 0, m_round_count = 0, m_outline_count = 0;
  std::size_t m_box_pattern = 0, m_outline_pattern = 0;
  std::vector<GrainVertex> m_box_vertices;
  GrainTriangles m_round_triangles;
  std::vector<std::array<float, 3>> m_outline_vertices;
  float m_eye_seconds = 0.f, m_light_seconds = 0.f;
  bool m_eye_ready = false, m_light_ready = false;
};

/// One of the jittered pictures whose mean is the picture.
struct SubFrame {
  int index = 0;
  int count = 1;
  const View* view = nullptr;
  Camera camera;          ///< relative to the centre of the bounds
  Eigen::Vector2f jitter; ///< shift of the picture [ndc]
  float seconds = 0.f;    ///< when within the exposure, from its middle [s]
  Eigen::Matrix4f clip_from_world;
  float scene_radius = 1.f;   ///< [m]
  float ground_height = 0.f;  ///< along up, relative to the centre of the bounds [m]
  bool surface_begun = false; ///< what the surface pass draws comes to what is there
  bool still = false;         ///< all sub-frames see the same, but for parts of a pixel
  PixelRect touched;          ///< outside it the picture is evenly lit floor and backdrop
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
  PassRate (*rate)(const RenderPlan& plan);
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
