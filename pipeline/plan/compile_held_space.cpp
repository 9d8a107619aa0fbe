#include <algorithm>

#include "pipeline/plan/compile_collider.h"
#include "pipeline/plan/compile_fem.h"
#include "pipeline/plan/compile_mpm.h"

namespace wry::pipeline {

namespace {

struct HeldShape {
  scene::ObstacleShape operator()(const shots::BoxRegion& box) const {
    scene::BoxObstacle obstacle;
    obstacle.centre = 0.5 * (*box.min + *box.max);
    obstacle.size = *box.max - *box.min;
    return obstacle;
  }
  scene::ObstacleShape operator()(const shots::SphereRegion& sphere) const {
    return scene::SphereObstacle{*sphere.centre, *sphere.radius};
  }
  scene::ObstacleShape operator()(const shots::CylinderRegion& cylinder) const {
    return scene::CylinderObstacle{*cylinder.from, *cylinder.to, *cylinder.radius};
  }
  // Refused before.
  scene::ObstacleShape operator()(const shots::ExpressionRegion&) const { return {}; }
  scene::ObstacleShape operator()(const shots::AttributeRegion&) const { return {}; }
};

/// A part of space in which matter is held or driven, at rest so far.
Result<mpm::HeldSpace> space_in(const shots::Region& where, const shots::Source& source) {
  const bool has_shape =
      !std::holds_alternative<shots::ExpressionRegion>(where) && !std::holds_alternative<shots::AttributeRegion>(where);
  if (!has_shape)
    return at_source(source, make_error(ErrorCode::bad_input, "particles are held and driven in a part of space; "
                                                              "expected where = {{ box | sphere | cylinder }}"));
  mpm::HeldSpace held;
  held.shape = std::visit(HeldShape{}, where);
  return held;
}

} // namespace

Result<mpm::HeldSpace> compile_held_space(const shots::Fixed& fixed) {
  Result<mpm::HeldSpace> held = space_in(fixed.where, fixed.source);
  if (!held)
    return held.error();
  held->name = *fixed.name;
  if (fixed.until)
    held->until = **fixed.until;
  return held;
}

Result<mpm::HeldSpace> compile_driven_space(const shots::Drive& drive,
                                            const std::vector<std::shared_ptr<const scene::Collider>>& colliders) {
  if (*drive.method != shots::DriveMethod::exact)
    return at_source(drive.method.source,
                     make_error(ErrorCode::bad_input, "particles are driven through their grid, where no spring "
                                                      "acts; write method = \"exact\" or leave it out"));
  Result<mpm::HeldSpace> driven = space_in(drive.where, drive.source);
  if (!driven)
    return driven.error();
  driven->name = *drive.name;
  if (drive.until)
    driven->until = **drive.until;
  if (drive.collider) {
    const auto named = std::find_if(colliders.begin(), colliders.end(),
                                    [&](const auto& collider) { return collider->name == **drive.collider; });
    if ((*named)->sequence() != nullptr)
      return at_source(drive.collider->source, cannot_follow(**drive.collider));
    driven->motion = (*named)->motion;
    return driven;
  }
  Result<scene::Motion> motion = compile_motion(drive.motion);
  if (!motion)
    return motion.error();
  driven->motion = std::move(*motion);
  return driven;
}

} // namespace wry::pipeline
