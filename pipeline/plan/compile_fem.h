#pragma once

#include <memory>

#include "shots/shot.h"
#include "sim/base/result.h"
#include "sim/fem/fem_plan.h"

namespace wry::pipeline {

/// The material of a shot as the elements need it. `label` names it in messages.
fem::FemMaterial compile_material(const shots::Material& material);

/// Gamma0 of a material as a function of place and time, empty when it has none. Errors: bad_input with the key's line
/// for a formula that does not compile.
Result<fem::RestCurvature> compile_rest_curvature(const shots::Material& material);

/// [fem] as the solver needs it; "auto" becomes a number here. `fps` bounds the automatic time step.
fem::FemSettings compile_fem_settings(const shots::FemOptions& options, double fps);

/// Unit vector along an axis.
Vec3 axis_vector(shots::Axis axis);

/// "bunny.toml:12:8: body.bunny.resolution: ..." in front of a message about this value.
Error at_source(const shots::Source& source, Error error);

} // namespace wry::pipeline
