#include <algorithm>

#include <fmt/format.h>

#include "shots/rules.h"

namespace wry::shots {

void Rules::check_collider(const Collider& collider) {
  const auto* box = std::get_if<OpenBoxShape>(&collider.shape);
  const auto* mesh = std::get_if<ColliderMeshShape>(&collider.shape);
  if (box) {
    check_container(*box, collider.source);
  }
  if (std::holds_alternative<PlaneShape>(collider.shape) &&
      (!collider.rotate.empty() || collider.size || *collider.scale != 1.0 || !collider.translate->isZero(0.0))) {
    refuse(collider.source, ": a plane stands by its point (or height) and normal; remove rotate, translate, size and "
                            "scale");
  }
  if (!mesh && *collider.motion.from == MotionFrom::file) {
    refuse(collider.motion.from.source, " = \"file\": only a mesh has a file to take its motion from");
  }
  if (mesh && mesh->sequence && mesh->node) {
    refuse(mesh->node->source, ": a sequence moves all of the file; remove node");
  }
  if (mesh && mesh->sequence && *collider.motion.from == MotionFrom::file) {
    refuse(collider.motion.from.source, " = \"file\": the mesh moves by its sequence; remove one of them");
  }
  if (*collider.motion.from == MotionFrom::file && !collider.motion.keys.empty()) {
    refuse(collider.motion.keys.front().source, ": motion = \"file\" takes no keys; remove one of them");
  }
  check_motion(collider.motion);
}

void Rules::check_container(const OpenBoxShape& box, const Source& source) {
  if (!box.open.empty() && !box.wall) {
    refuse(below(source, "box.wall"), " is missing: a box with open sides is its walls, and they need a thickness");
  }
  if (box.open.empty() && box.wall) {
    refuse(box.wall->source, ": the box has no open side, so it is solid; remove wall, or name a side in open");
  }
  if (box.wall && 2.0 * **box.wall >= box.size->minCoeff()) {
    refuse(box.wall->source, fmt::format(" = {}: expected less than half of the least length, {}", **box.wall,
                                         0.5 * box.size->minCoeff()));
  }
}

void Rules::check_motion(const Motion& motion) {
  for (std::size_t i = 1; i < motion.keys.size(); ++i) {
    const Located<double>& time = motion.keys[i].time;
    if (*time <= *motion.keys[i - 1].time) {
      refuse(time.source, fmt::format(" = {}: expected more than the {} s of the key before it; keys stand in order "
                                      "of time",
                                      *time, *motion.keys[i - 1].time));
      return;
    }
  }
}

void Rules::check_drive(const Drive& drive) {
  if (!*drive.positions && !*drive.microrotations) {
    refuse(drive.positions.source, " is empty: expected \"positions\", \"microrotations\" or both");
  }
  check_motion(drive.motion);
  const bool soft = *drive.method == DriveMethod::soft;
  if (soft && *drive.stiffness == 0.0 && *drive.turning_stiffness == 0.0) {
    refuse(below(drive.source, "stiffness"),
           " is missing: a soft drive needs stiffness (N/m), turning_stiffness (N m) or both");
  }
  for (const Located<double>& stiffness : {drive.stiffness, drive.turning_stiffness}) {
    if (!soft && *stiffness > 0.0) {
      refuse(stiffness.source, ": only soft drives have it; write method = \"soft\" or remove it");
    }
  }
  const Material* material = material_of(*drive.body);
  if (!*drive.positions && material != nullptr && !is_micropolar(*material->model)) {
    refuse(drive.microrotations.source,
           fmt::format(": body '{}' has no microrotations, so nothing would be driven; give it a micropolar model or "
                       "drive positions",
                       *drive.body));
  }
}

void Rules::check_load(const Load& load) {
  const auto given = [](const auto& components) {
    return std::any_of(components.begin(), components.end(), [](const auto& entry) { return entry.has_value(); });
  };
  if (!given(load.force) && !given(load.torque)) {
    refuse(below(load.source, "force"), " is missing: give force = { x = ... }, torque = { x = ... } or both");
  }
  const Material* material = material_of(*load.body);
  if (given(load.torque) && material != nullptr && !is_micropolar(*material->model)) {
    refuse(below(load.source, "torque"),
           fmt::format(": body '{}' has no microrotations that a torque could turn; give it a micropolar model, or "
                       "use two forces",
                       *load.body));
  }
}

} // namespace wry::shots
