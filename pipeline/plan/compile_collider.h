#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pipeline/plan/scene_plan.h"
#include "shots/shot.h"
#include "sim/base/result.h"
#include "sim/scene/collider.h"

namespace wry::pipeline {

/// A collider ready for every method.
struct CompiledCollider {
  std::shared_ptr<const scene::Collider> collider;
  std::vector<Asset> assets;
  std::vector<std::string> notes; ///< about its mesh, a sentence each
};

/// Places a collider, imports its mesh, its motion and where its vertices are over the shot's frames. Errors: bad_input
/// with the key's line; missing_input for a file.
Result<CompiledCollider> compile_collider(const shots::Collider& collider, const shots::ShotSettings& shot);

/// Why a drive cannot take the motion of a collider that deforms.
Error cannot_follow(const std::string& collider);

/// keys, pivot and ease of the shot as a motion. Errors: bad_input with the key's line.
Result<scene::Motion> compile_motion(const shots::Motion& motion);

} // namespace wry::pipeline
