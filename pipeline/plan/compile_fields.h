#pragma once

#include <memory>

#include "shots/shot.h"
#include "sim/base/result.h"
#include "sim/fem/fem_plan.h"
#include "sim/scene/expression.h"

namespace wry::pipeline {

/// What a body's formulas become. Errors: bad_input with the line of the key, for a formula that does not compile, uses
/// what the body does not have, or has no finite value somewhere in the body.

/// Gamma0 of a material; empty when it has none. It is evaluated once over the body, at the times 0 and `end`, so that
/// a formula without a value is refused before anything runs.
Result<fem::RestCurvature> compile_rest_curvature(const shots::Material& material,
                                                  const std::shared_ptr<const geometry::TetMesh>& mesh, double end);
/// Whether Gamma0 depends on the time.
bool rest_curvature_moves(const shots::Material& material);

/// material.X.vary, per tet. Errors: also for a factor that is not above zero.
Result<fem::MaterialFactors> compile_factors(const shots::Material& material, const geometry::TetMesh& mesh);

/// A formula that may use the attributes of the mesh. Errors: bad_input with the line of the key.
Result<scene::Expression> compile_formula(const shots::Located<shots::Expression>& asked,
                                          const geometry::TetMesh& mesh);

/// The middles of the tets, with the means of what their corners carry.
scene::RestPoints tet_centres(const geometry::TetMesh& mesh);

} // namespace wry::pipeline
