#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/image.h"
#include "render/render_plan.h"
#include "sim/state/frame.h"

namespace wry::render {

/// One picture that is asked for.
struct Picture {
  std::string view = "beauty";
  double orbit_turns = 0.0;       ///< added to the camera's azimuth; 1 = once round
  std::vector<std::string> slate; ///< lines of this picture, under the plan's
};

/// Processor time of one pass, summed over the sub-frames of one picture.
struct PassTime {
  std::string name;
  double cpu_ms = 0.0; ///< of all threads
  double wall_ms = 0.0;
};

/// Draws frames of one scene by one plan. Holds one OpenGL context: use it on the thread that made it, make one per
/// process, and never fork after it with raster_threads above 0.
class Renderer {
public:
  /// Errors: bad_input (plan or scene), unavailable (no OSMesa and no EGL here, or a build without them).
  static Result<Renderer> create(const RenderPlan& plan, const SceneStatic& scene);
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  /// The finished picture, with slate and colour bar. Errors: bad_input (frame, view, camera inside a body).
  Result<Image> draw(const Frame& frame, const Picture& picture);

  /// The same light before exposure, tone curve and text.
  Result<LinearImage> draw_linear(const Frame& frame, const Picture& picture);

  /// What each pass of the last picture cost.
  const std::vector<PassTime>& pass_times() const;

  const GlVersion& gl_version() const;

private:
  struct Machinery;
  explicit Renderer(std::unique_ptr<Machinery> machinery);
  std::unique_ptr<Machinery> m_machinery;
};

} // namespace wry::render
