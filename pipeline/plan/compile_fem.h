#pragma once

#include <memory>

#include "shots/shot.h"
#include "sim/base/result.h"
#include "sim/fem/fem_plan.h"

namespace wry::pipeline {

/// The material of a shot as the elements need it. `label` names it in messages.
fem::FemMaterial compile_material(const shots::Material& material);

/// [fem] as the solver needs it; "auto" becomes a number here. `fps` bounds the automatic time step.
fem::FemSettings compile_fem_settings(const shots::FemOptions& options, double fps);

/// [contact] as the solver needs it.
std::optional<fem::ContactOptions> compile_contact(const std::optional<shots::ContactOptions>& contact);

/// Unit vector along an axis.
Vec3 axis_vector(shots::Axis axis);

/// "bunny.toml:12:8: body.bunny.resolution: ..." in front of a message about this value.
Error at_source(const shots::Source& source, Error error);

} // namespace wry::pipeline
