#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "render/burial.h"
#include "render/grain_cloud.h"
#include "render/render_plan.h"
#include "render/smooth_normals.h"
#include "sim/state/frame.h"

namespace wry::render {

/// One vertex as the graphics library reads it. Positions are relative to the centre of the plan's bounds.
struct DrawVertex {
  std::array<float, 3> position;                           ///< [m]
  std::array<float, 3> normal;                             ///< unit
  std::uint32_t look;                                      ///< row of the look table
  float value;                                             ///< heat in [0, 1]; HEAT_ABSENT, HEAT_NOT_A_NUMBER
  std::array<std::uint8_t, 4> tint = {255, 255, 255, 255}; ///< square root of what multiplies the base colour
};

/// Rows of the look table that the shaders have room for.
constexpr std::size_t LOOKS_MAX = 64;

/// Value of a body without the channel of a heat view: drawn in plain grey.
constexpr float HEAT_ABSENT = -1.f;
/// Value of a channel entry that is not a finite number: drawn in magenta. So large that interpolation cannot hide it.
constexpr float HEAT_NOT_A_NUMBER = -1e6f;

/// Grains of one shape that are drawn from wherever the eye and the light are.
struct DrawCloud {
  enum class For { both, eye, light } seen_by = For::both; ///< of a heap the light needs fewer grains than the eye
  GrainShape shape = GrainShape::brick;
  int segments = 0;       ///< of round shapes; 0: drawn as boxes
  std::uint32_t body = 0; ///< from 1, in the order of the scene; 0: signs
  std::vector<DrawGrain> grains;
};

/// Triangles [begin, end) of three corners each that take their base colour from a picture.
struct TexturedRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  std::size_t texture = 0; ///< of the scene's textures
};

/// What one picture draws: triangles that share vertices, or, where each triangle needs its own, three vertices each.
struct DrawList {
  std::vector<DrawVertex> vertices;
  std::vector<std::uint32_t> indices;           ///< empty: vertices in threes
  std::vector<std::array<float, 3>> velocities; ///< per vertex [m/s]; empty: nothing is blurred
  std::vector<std::array<float, 2>> uvs;        ///< per vertex; empty: nothing is textured
  std::vector<TexturedRange> textured;          ///< the rest has no texture
  std::vector<DrawCloud> clouds;
  std::size_t outward_end = 0;        ///< corners up to here are of closed surfaces of which nobody sees a back face
  std::size_t clear_begin = SIZE_MAX; ///< corners from here on are of transparent bodies
  bool in_threes = false;             ///< each triangle has vertices of its own, `indices` stays empty
  bool heat = false;                  ///< `value` counts
};

/// The bodies of a scene, made ready once; each frame then only moves them.
class DrawableScene {
public:
  /// Errors: bad_input for triangles that name vertices that are not there, or a scene without a triangle.
  static Result<DrawableScene> create(const RenderPlan& plan, const SceneStatic& scene);

  /// The triangles of a frame as a view sees them. Errors: bad_input for a frame of another scene, positions that are
  /// not finite, or a heat channel that no body has or that has the wrong size.
  Result<DrawList> list(const Frame& frame, const View& view) const;

  /// Looks in the order of DrawVertex::look; the first is clay.
  const std::vector<Look>& look_table() const { return m_looks; }
  const std::vector<Image>& textures() const { return m_textures; }
  std::int64_t triangle_count() const { return m_triangle_count; }

  /// Error: bad_input when the point [m] is inside a body (its winding number is above one half).
  Status check_outside(const Frame& frame, const Vec3& point) const;

private:
  struct Body {
    SplitSurface surface;
    std::uint32_t look = 0;
    std::uint32_t grain_look = 0;              ///< of particles: its own row, with room for brighter grains
    std::vector<std::int32_t> tet_of_triangle; ///< empty for surfaces
    std::shared_ptr<const MeshAppearance> appearance;
    std::vector<std::uint32_t> material_rows; ///< look row per material of the appearance
    std::size_t first_texture = 0;
    bool closed_outward = false; ///< at rest
  };

  /// Where creases and normals are found: the mesh of a grain at the size of its grains.
  static Points drawn_rest(const SceneBody& body);
  Status add_body(const RenderPlan& plan, const SceneBody& body, std::uint32_t look);
  Status check_frame(const Frame& frame) const;
  bool is_outward(const Frame& frame, std::size_t body, const View& view) const;
  Status append_surface(const Frame& frame, std::size_t body, const View& view, DrawList& list) const;
  Status append_cloud(const Frame& frame, std::size_t body, const View& view, DrawList& list) const;
  Status append_marks(const Frame& frame, const View& view, DrawList& list) const;
  static std::vector<std::int32_t> triangles_by_texture(const Body& body);
  static int texture_of(const Body& body, std::int32_t triangle);
  void dress_corner(const Body& body, std::int32_t triangle, int corner, DrawList& list) const;
  void append_mesh_grains(const GrainCloud& cloud, std::size_t body, DrawList& list) const;

  SceneStatic m_scene;
  Vec3 m_origin = Vec3::Zero();
  std::vector<Body> m_bodies;
  std::vector<Look> m_looks;
  std::int64_t m_triangle_count = 0;
  double m_radius = 1.0;
  double m_pixel = 0.0; ///< side of a pixel at the centre of the bounds [m]
  std::optional<Floor> m_floor;
  bool m_blurred = false;
  bool m_has_clouds = false;
  std::vector<Image> m_textures;
};

} // namespace wry::render
