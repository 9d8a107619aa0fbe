#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <fmt/format.h>

#include "shots/rules.h"

namespace wry::shots {

void Rules::check_material(const Material& material) {
  if (*material.model == MaterialModel::mpm) {
    if (material.matter.reorient &&
        (material.matter.plastic_map || material.matter.stress_map || material.matter.strain_map)) {
      refuse(material.matter.reorient->source,
             ": grains that reorient have their maps from the limits; remove plastic_map, stress_map and strain_map");
    }
    return; // what its numbers allow is for sim/mpm to say
  }
  for (const Source& given : material.matter.given) {
    refuse(given, ": only model = \"mpm\" reads this key; remove it");
  }
  for (const PerAxis* value : {&material.matter.youngs_modulus, &material.matter.poisson_ratio}) {
    if (value->is_table) {
      Source source = value->values[0].source;
      source.key = source.key.substr(0, source.key.rfind('.'));
      refuse(source, ": only model = \"mpm\" is stiffer along one axis than along another; give one number");
      return;
    }
  }
  check_condensed(material);
  check_plate_only(material);
  if (is_micropolar(*material.model) && *material.couple_modulus_ratio == 0.0 && *material.length_scale == 0.0 &&
      *material.rotary_inertia == 0.0) {
    refuse(material.couple_modulus_ratio.source,
           " = 0: with length_scale = 0 and rotary_inertia = 0 nothing holds the microrotations; expected one of the "
           "three above 0, or model = \"neo-hookean\"");
  }
  const Curvature& curvature = material.curvature;
  *curvature.model == CurvatureModel::isotropic ? check_isotropic(curvature) : check_orthotropic(curvature);
}

void Rules::check_isotropic(const Curvature& curvature) {
  for (const auto& row : curvature.stiffness) {
    for (const auto& entry : row) {
      if (*entry > 0.0) {
        refuse(entry.source, ": stiffness is of the orthotropic model; write curvature.model = \"orthotropic\"");
        return;
      }
    }
  }
  if (*curvature.alpha + 3.0 * *curvature.gamma < 0.0) {
    refuse(curvature.gamma.source, fmt::format(" = {}: expected gamma >= -alpha/3 = {:.6g}, or the energy of curvature "
                                               "has no least value",
                                               *curvature.gamma, -*curvature.alpha / 3.0));
  }
}

void Rules::check_orthotropic(const Curvature& curvature) {
  bool any = false;
  for (const auto& row : curvature.stiffness) {
    for (const auto& entry : row) {
      any = any || *entry > 0.0;
    }
  }
  if (!any) {
    refuse(curvature.model.source, " = \"orthotropic\": expected curvature.stiffness = { yx = ..., ... } with an entry "
                                   "above 0");
  }
  for (const Located<double>& weight : {curvature.alpha, curvature.beta, curvature.gamma}) {
    if (*weight != 1.0) {
      refuse(weight.source, ": a weight of the isotropic model; the orthotropic one has stiffness = { xx ... zz }");
      break;
    }
  }
  check_basis(curvature.basis);
}

void Rules::check_basis(const Located<Mat3>& basis) {
  constexpr double TOLERANCE = 1e-6;
  const Mat3 product = basis->transpose() * *basis;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double length = std::sqrt(product(i, i));
    if (std::abs(length - 1.0) > TOLERANCE) {
      refuse(basis.source,
             fmt::format(": axis {} has length {:.9g}; expected 1 within {:g}", "xyz"[i], length, TOLERANCE));
      return;
    }
    const Eigen::Index j = (i + 1) % 3;
    if (std::abs(product(i, j)) > TOLERANCE) {
      refuse(basis.source, fmt::format(": axes {} and {} have the dot product {:.9g}; expected 0 within {:g}", "xyz"[i],
                                       "xyz"[j], product(i, j), TOLERANCE));
      return;
    }
  }
  if (basis->determinant() < 0.0) {
    refuse(basis.source, ": the axes are left-handed (determinant -1); turn one of them around");
  }
}

} // namespace wry::shots
