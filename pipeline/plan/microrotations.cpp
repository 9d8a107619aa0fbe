#include "pipeline/plan/microrotations.h"

#include <algorithm>

#include <fmt/format.h>

namespace wry::pipeline {

namespace {

/// What in the shot reads the microrotations of a body; empty: nothing.
std::string reader_of(const shots::Shot& shot) {
  for (const shots::Located<shots::View>& view : shot.render.views) {
    for (const char* channel : {"microrotation", "angular_velocity"}) {
      if (view->name.find(channel) != std::string::npos)
        return "the view " + view->name + " shows them";
    }
  }
  return "";
}

} // namespace

MicrorotationChoice choose_microrotations(const shots::Shot& shot, const shots::Body& body,
                                          const shots::Material& material) {
  const double nu = *material.poisson_ratio;
  const bool asked = *material.microrotation == shots::Microrotation::condensed;
  if (asked) {
    MicrorotationChoice choice{true, "asked for: 3 dofs per node, the corotated model in each element", ""};
    if (nu > 0.0)
      choice.warning = fmt::format("body {}: microrotations are condensed at poisson_ratio = {}; the rotation of the "
                                   "matter minimises the energy only while the principal stretches sum to less than "
                                   "3 + 2 mu/lambda = {:.4g}; beyond, solved microrotations differ",
                                   *body.name, nu, 3.0 + (1.0 - 2.0 * nu) / nu);
    return choice;
  }
  if (*material.microrotation == shots::Microrotation::solved)
    return {false, "asked for", ""};
  const bool plain = *material.model == shots::MaterialModel::micropolar &&
                     (*body.element == shots::Element::automatic || *body.element == shots::Element::tet4) &&
                     *body.quadrature == shots::Quadrature::full;
  if (!plain)
    return {false, "the model or the element needs them", ""};
  if (*material.length_scale > 0.0)
    return {false, "length_scale > 0: energy of curvature", ""};
  if (*material.rotary_inertia > 0.0)
    return {false, "rotary_inertia > 0", ""};
  if (*material.couple_modulus_ratio < 1.0)
    return {false, "couple_modulus_ratio < 1: the rotation of the matter is not the one of least energy", ""};
  if (nu > 0.0)
    return {false, "poisson_ratio > 0: under stretch the rotation of the matter is not always the one of least energy",
            ""};
  if (const std::string reader = reader_of(shot); !reader.empty())
    return {false, reader, ""};
  return {true, "no energy of curvature, poisson_ratio <= 0 and nothing reads them: 3 dofs per node, minimised exactly",
          ""};
}

} // namespace wry::pipeline
