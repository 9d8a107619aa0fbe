#pragma once

#include <Eigen/Geometry>

#include "sim/base/result.h"
#include "sim/base/types.h"
#include "sim/state/frame.h"

namespace wry::render {

/// How far the subject reaches over a whole sequence: its box and, tighter, the farthest point in each of many
/// directions. Cameras are framed and shadow maps are fitted to it, so that nothing is clipped or swims between frames.
class SubjectBounds {
public:
  SubjectBounds();

  /// Takes in points, n x 3 [m]. Points that are not finite are left out (the renderer refuses them).
  void include(const Eigen::Ref<const Points>& points);
  /// Takes in every body of the frame that is drawn. Errors: as world_positions().
  Status include(const SceneStatic& scene, const Frame& frame);
  void include(const SubjectBounds& other);

  bool empty() const { return m_box.isEmpty(); }
  const Eigen::AlignedBox3d& box() const { return m_box; }
  Vec3 centre() const { return m_box.center(); }
  /// Half the diagonal of the box [m]; the renderer's measure of the scene's size.
  double radius() const { return 0.5 * m_box.diagonal().norm(); }
  /// Points of the subject, one per direction, n x 3: their convex hull is the subject's within about 1 %.
  const Points& outline() const { return m_outline; }

private:
  Status include_cloud(const SceneBody& body, const FrameBody& on_frame, int frame_number);

  Eigen::AlignedBox3d m_box;
  Eigen::VectorXd m_reach; ///< per direction, how far the outline point lies along it
  Points m_outline;
};

/// Where the vertices of one body are on this frame, n x 3 [m]: its "position" channel, or its transform of the rest
/// positions when it has none. Errors: bad_input when the channel has the wrong shape or values that are not finite.
Result<Points> world_positions(const SceneBody& body, const FrameBody& on_frame, int frame_number);

} // namespace wry::render
