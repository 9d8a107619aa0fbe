#pragma once

#include "render/camera.h"
#include "shots/shot.h"
#include "sim/base/result.h"
#include "sim/scene/motion.h"
#include "sim/state/frame.h"

namespace wry::pipeline {

/// How the camera of a shot stands on each frame: still, along keys, as animated in an artist's file (without its
/// roll), round the subject, or looking at a body.
class CameraMotion {
public:
  /// Errors: bad_input with the line of keys that are not in order, or of a body to look at that the scene has not;
  /// those of import_motion() for a file.
  static Result<CameraMotion> create(const shots::Shot& shot, const SceneStatic& scene,
                                     const render::SubjectBounds& bounds);

  /// The camera that holds for the whole sequence, and frames it.
  const render::CameraPlan& plan() const { return m_plan; }

  /// Whether at() differs from plan().
  bool moves() const { return !m_keys.empty() || m_file_motion.moves() || m_turns != 0.0 || m_body >= 0; }

  /// The camera on one frame. Errors: bad_input for a body whose positions are not finite.
  Result<render::CameraPlan> at(const Frame& frame) const;

private:
  struct Key {
    double frame = 0;
    Eigen::Matrix<double, 7, 1> place; ///< position, target [m], lens [mm]
  };

  Status take_file(const shots::Camera& camera, shots::Axis up);
  render::CameraPlan along_keys(double frame) const;
  render::CameraPlan along_file(const scene::Pose& pose) const;

  render::CameraPlan m_plan;
  std::vector<Key> m_keys;
  scene::Motion m_file_motion;
  double m_turns = 0.0;
  double m_first = 0.0;
  double m_last = 1.0;
  int m_body = -1;
  SceneBody m_looked_at;
  render::SubjectBounds m_bounds;
  Vec3 m_up = Vec3::UnitY();
  render::ImageSize m_size;
};

} // namespace wry::pipeline
