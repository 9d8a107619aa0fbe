#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/render_plan.h"
#include "render/smooth_normals.h"
#include "sim/state/frame.h"

namespace wry::render {

/// One vertex as the graphics library reads it. Positions are relative to the centre of the plan's bounds.
struct DrawVertex {
  std::array<float, 3> position; ///< [m]
  std::array<float, 3> normal;   ///< unit
  std::uint32_t look;            ///< row of the look table
  float value;                   ///< heat in [0, 1]; HEAT_ABSENT, HEAT_NOT_A_NUMBER
};

/// Value of a body without the channel of a heat view: drawn in plain grey.
constexpr float HEAT_ABSENT = -1.f;
/// Value of a channel entry that is not a finite number: drawn in magenta. So large that interpolation cannot hide it.
constexpr float HEAT_NOT_A_NUMBER = -1e6f;

/// What one picture draws: triangles that share vertices, or, where each triangle needs its own, three vertices each.
struct DrawList {
  std::vector<DrawVertex> vertices;
  std::vector<std::uint32_t> indices; ///< empty: vertices in threes
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
  std::int64_t triangle_count() const { return m_triangle_count; }

  /// Error: bad_input when the point [m] is inside a body (its winding number is above one half).
  Status check_outside(const Frame& frame, const Vec3& point) const;

private:
  struct Body {
    SplitSurface surface;
    std::uint32_t look = 0;
    std::vector<std::int32_t> tet_of_triangle; ///< empty for surfaces
  };

  Status check_frame(const Frame& frame) const;
  Status append_body(const Frame& frame, std::size_t body, const View& view, DrawList& list) const;

  SceneStatic m_scene;
  Vec3 m_origin = Vec3::Zero();
  std::vector<Body> m_bodies;
  std::vector<Look> m_looks;
  std::int64_t m_triangle_count = 0;
};

} // namespace wry::render
