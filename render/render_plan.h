#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/camera.h"
#include "render/gl_backend.h"
#include "render/lights.h"
#include "render/look.h"
#include "render/mesh_appearance.h"
#include "render/view.h"

namespace wry::render {

/// What the subject stands on: an endless studio floor that melts into the backdrop.
struct Ground {
  enum class Kind { none, studio, catch_shadow }; ///< catch_shadow: seen only where the subject darkens it
  Kind kind = Kind::studio;
  std::optional<double> height; ///< along up [m]; absent: the lowest point of the sequence
  Eigen::Vector3f colour = Eigen::Vector3f(.19f, .19f, .195f); ///< linear
};

/// Whether what is behind the subject is drawn, or left clear for another picture.
enum class Background { drawn, clear };

/// Whether pictures come with distance, normal, velocity and body of each pixel.
enum class DataWanted { no, yes };

/// Everything that a sequence of pictures is drawn by. Immutable once a Renderer has it.
struct RenderPlan {
  ImageSize size;
  int samples = 4; ///< jittered sub-frames a picture: 1 (draft), 4 (dailies), 16 (final); 1 ... 256
  Vec3 up = Vec3::UnitY();
  CameraPlan camera;
  Framing framing = Framing::still;
  Rig rig = studio_rig();
  Ground ground;
  std::map<std::string, Look> looks; ///< by name; a body whose look is not here gets `default_look`
  Look default_look;
  std::map<std::string, std::shared_ptr<const MeshAppearance>> appearances; ///< by body: it wears its file's materials
  std::vector<View> views = standard_views();
  double exposure_stops = 0.0; ///< -16 ... 16
  Tone tone = Tone::filmic;    ///< of views that leave it open
  Background background = Background::drawn;
  DataWanted data = DataWanted::no;
  int bits = 8;         ///< 8 or 16 a channel
  double fps = 24.0;    ///< [1/s]
  double shutter = 0.0; ///< open time as a part of a frame; 0: no motion blur, 0.5: film; 0 ... 1
  /// Whether grains that are proven to be behind others are drawn all the same: slower, the same
  /// picture but for slivers that the first sub-frame cannot see, a pixel in some thousands.
  enum class HiddenGrains { left_out, drawn } hidden_grains = HiddenGrains::left_out;
  SubjectBounds bounds;           ///< of the whole sequence
  std::vector<std::string> slate; ///< lines burned in at the lower left of every picture; empty: none
  GlBackend backend = GlBackend::automatic;
  int raster_threads = 0; ///< OpenGL's own threads; keep 0 and run one process per core
};

/// Errors: bad_input for a value outside its limits, naming it.
Status check_render_plan(const RenderPlan& plan);

/// The view of that name. Errors: bad_input, naming the views that there are.
Result<View> find_view(const RenderPlan& plan, const std::string& name);

} // namespace wry::render
