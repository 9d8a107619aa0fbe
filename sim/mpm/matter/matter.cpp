#include "sim/mpm/matter/matter.h"

namespace wry::mpm {

bool is_linear_in_strain(Elasticity elasticity) {
  return elasticity != Elasticity::fixed_corotated;
}

bool needs_maps(const Matter& matter) {
  return !matter.isotropic && (matter.plasticity.law != Plasticity::none || !is_linear_in_strain(matter.elasticity));
}

std::string_view elasticity_name(Elasticity elasticity) {
  switch (elasticity) {
  case Elasticity::linear:
    return "linear";
  case Elasticity::hencky:
    return "hencky";
  case Elasticity::fixed_corotated:
    return "fixed-corotated";
  }
  return "?";
}

std::string_view plastic_law_name(Plasticity law) {
  switch (law) {
  case Plasticity::none:
    return "none";
  case Plasticity::snow:
    return "snow";
  case Plasticity::drucker_prager:
    return "drucker-prager";
  case Plasticity::shear:
    return "shear";
  }
  return "?";
}

} // namespace wry::mpm
