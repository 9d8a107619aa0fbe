#pragma once

#include <optional>

#include "render/subject_bounds.h"
#include "sim/base/result.h"
#include "sim/base/types.h"

namespace wry::render {

struct ImageSize {
  int width = 1920;  ///< [pixels] 16 ... 16384
  int height = 1080; ///< [pixels] 16 ... 16384
};

/// A camera that is put somewhere, instead of being framed to the subject.
struct PlacedCamera {
  Vec3 eye = Vec3(0, 0, 5);   ///< [m]
  Vec3 target = Vec3::Zero(); ///< [m]
  std::optional<Vec3> up;     ///< what points upward in the picture; absent: the world's up
};

/// What is asked of the camera. Angles are about the subject, as a turntable turns.
struct CameraPlan {
  double lens_mm = 65.0;         ///< focal length on a 36 mm wide film back; 10 ... 1000
  double azimuth_degrees = 30;   ///< 0 looks along -z (up y) or +y (up z); turns counter-clockwise seen from above
  double elevation_degrees = 14; ///< above the horizon; -89 ... 89
  double margin = 0.12;          ///< free space at the tightest side, as a part of the picture; 0 ... 0.9
  std::optional<PlacedCamera> placed;
  /// Depth of field of a lens of this f-number, in the scene's own metres; absent: everything is sharp. 0.1 ... 128
  std::optional<double> f_stop;
  std::optional<double> focus_distance; ///< along the view axis [m]; absent: the nearest part of the subject's middle
};

/// Whether the frame must hold while the camera goes round.
enum class Framing { still, orbit };

/// A pinhole camera. World -> camera axes: x right, y up, z back.
struct Camera {
  Vec3 eye = Vec3::Zero();
  Mat3 axes = Mat3::Identity(); ///< columns: right, up, back; unit
  double tan_half_width = 0.3;
  double tan_half_height = 0.2;
  double near_distance = 0.01; ///< [m]
};

/// Points the camera at the subject from the azimuth and elevation of the plan plus `orbit_turns` (1 = once round), as
/// near as the margin allows for every point of the outline; with Framing::orbit as near as every turn allows, so that
/// the subject does not breathe. Errors: bad_input for an empty subject or values outside the limits above.
Result<Camera> frame_camera(const CameraPlan& plan, const Vec3& up, const SubjectBounds& bounds, const ImageSize& size,
                            Framing framing, double orbit_turns);

/// Turn of picture `index` of a turntable of `count`: index / count, so that the last is not the first again.
double turntable_turns(int index, int count);

/// Unit axes with `up` as y: columns x (right of azimuth 0), y (up), z (towards the camera at azimuth 0).
Mat3 world_frame(const Vec3& up);

} // namespace wry::render
