#pragma once

#include <string>
#include <vector>

#include "sim/mpm/matter/matter.h"
#include "sim/mpm/matter/orientation.h"

namespace wry::mpm {

/// The laws of a material as numbers, checked. Warnings (hydrostatic flow, an A^E without major symmetry) are added to
/// `warnings` unless it is nullptr. Errors: bad_input, with the violated inequality, both sides and where the value may
/// lie.
Result<Matter> make_matter(const Material& material, std::vector<std::string>* warnings = nullptr);

/// The limits of grains that reorient.
OrientationLimits orientation_limits(const Reorientation& grains);

/// Density times the square of the fastest wave [Pa]; of grains that reorient, in the stiffest of their limits.
double stiffest_modulus(const Material& material, const Matter& matter);

} // namespace wry::mpm
