#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/image.h"
#include "render/render_plan.h"
#include "sim/state/frame.h"

namespace wry::render {

/// One picture that is asked for.
struct Picture {
  std::string view = "beauty";
  double orbit_turns = 0.0;         ///< added to the camera's azimuth; 1 = once round
  std::optional<CameraPlan> camera; ///< of this picture, in place of the plan's
  std::vector<std::string> slate;   ///< lines of this picture, under the plan's
};

/// What lies behind each pixel's centre, rows from the top; nothing: distance 0, body 0. Not filtered.
struct DataLayers {
  int width = 0;
  int height = 0;
  std::vector<float> distance;                ///< along the view axis [m]
  std::vector<std::array<float, 3>> normal;   ///< in the world, towards the eye
  std::vector<std::array<float, 3>> velocity; ///< in the world [m/s]
  std::vector<std::uint32_t> body;            ///< from 1, in the order of the scene
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

  /// Distance, normal, velocity and body of what the picture shows. Errors: as draw(); bad_input unless the plan asks
  /// for data.
  Result<DataLayers> draw_data(const Frame& frame, const Picture& picture);

  /// What each pass of the last picture cost.
  const std::vector<PassTime>& pass_times() const;

  const GlVersion& gl_version() const;

private:
  struct Machinery;
  explicit Renderer(std::unique_ptr<Machinery> machinery);
  std::unique_ptr<Machinery> m_machinery;
};

} // namespace wry::render
