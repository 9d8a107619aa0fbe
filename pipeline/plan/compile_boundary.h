#pragma once

#include <memory>
#include <vector>

#include "shots/shot.h"
#include "sim/base/result.h"
#include "sim/fem/fem_plan.h"
#include "sim/scene/collider.h"

namespace wry::pipeline {

/// What moves nodes of a body. Errors: bad_input with the line of the key that is wrong, and when no node is picked.

/// `body` and `mesh`: those that the drive names. `colliders`: all of the shot.
Result<fem::DrivenNodes> compile_drive(const shots::Drive& drive, int body, const geometry::TetMesh& mesh,
                                       const std::vector<std::shared_ptr<const scene::Collider>>& colliders);

Result<fem::FemLoad> compile_load(const shots::Load& load, int body, const geometry::TetMesh& mesh);

/// body.X.rest_rotation, per vertex and per tet; nothing when the body has none.
Status compile_rest_rotation(const shots::Body& asked, fem::FemBody& body);

} // namespace wry::pipeline
