#include "pipeline/plan/microrotations.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace wry::pipeline {

namespace {

using Kind = shots::MeasureKind;
/// Measures of microrotations, or of what pushes against them.
constexpr std::array READING_KINDS = {Kind::element_twist_max, Kind::rotation_distance, Kind::curvature_error,
                                      Kind::rotation_interpolation_error, Kind::reaction_torque};

std::string reading_view(const shots::Shot& shot) {
  for (const shots::Located<shots::View>& view : shot.render.views) {
    if (view->kind == shots::ViewKind::directors)
      return "the view directors shows them";
    for (const char* channel : {"microrotation", "angular_velocity", "point_rotation"}) {
      if (view->channel.find(channel) != std::string::npos)
        return fmt::format("the view {} shows them", view->name);
    }
  }
  return "";
}

/// What in the shot reads, drives or loads the microrotations of a body; empty: nothing. A [[fixed]] that holds them
/// with the positions does not count: without energy of curvature nothing carries its rotations into the body.
std::string reader_of(const shots::Shot& shot, const shots::Body& body) {
  if (std::string view = reading_view(shot); !view.empty())
    return view;
  for (const shots::Measure& measure : shot.measures) {
    if (*measure.body == *body.name &&
        std::find(READING_KINDS.begin(), READING_KINDS.end(), *measure.kind) != READING_KINDS.end())
      return fmt::format("the measure {} reads them", *measure.name);
  }
  for (const shots::Drive& drive : shot.drives) {
    if (*drive.body == *body.name && *drive.microrotations)
      return fmt::format("the drive {} turns them", *drive.name);
  }
  for (const shots::Fixed& fixed : shot.fixed) {
    if (*fixed.body == *body.name && *fixed.hold_microrotations && !*fixed.hold_positions)
      return fmt::format("the hold {} holds them and not positions", *fixed.name);
  }
  for (const shots::Load& load : shot.loads) {
    if (*load.body == *body.name && std::any_of(load.torque.begin(), load.torque.end(),
                                                [](const auto& component) { return component.has_value(); }))
      return fmt::format("the load {} turns them", *load.name);
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
    if (const std::string reader = reader_of(shot, body); !reader.empty())
      choice.warning = fmt::format("body {}: microrotations are condensed, but {}: there are none; leave out "
                                   "microrotation = \"condensed\"",
                                   *body.name, reader);
    else if (nu > 0.0)
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
  if (const std::string reader = reader_of(shot, body); !reader.empty())
    return {false, reader, ""};
  return {true, "no energy of curvature, poisson_ratio <= 0 and nothing reads them: 3 dofs per node, minimised exactly",
          ""};
}

} // namespace wry::pipeline
