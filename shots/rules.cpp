#include <fmt/format.h>

#include "shots/rules.h"

#include "shots/bind.h"

namespace wry::shots {

void Rules::check() {
  if (m_shot.bodies.empty() && !m_diagnostics.any_under("body")) {
    m_diagnostics.add(Source{m_shot.file, 1, 1, "body", Origin::file},
                      " is missing: a shot needs at least one [[body]]");
  }
  for (const Body& body : m_shot.bodies) {
    if (sound(body)) {
      check_body(body);
    }
  }
  for (const Material& material : m_shot.materials) {
    if (sound(material)) {
      check_material(material);
    }
  }
  for (const Fixed& fixed : m_shot.fixed) {
    if (sound(fixed)) {
      need_body(*fixed.body, fixed.source);
      check_region(fixed.where);
    }
  }
  for (const Collider& collider : m_shot.colliders) {
    if (sound(collider)) {
      check_collider(collider);
    }
  }
  for (const Drive& drive : m_shot.drives) {
    if (sound(drive)) {
      need_body(*drive.body, drive.source);
      check_region(drive.where);
      check_drive(drive);
    }
  }
  for (const Load& load : m_shot.loads) {
    if (sound(load)) {
      need_body(*load.body, load.source);
      if (load.where) {
        check_region(*load.where);
      }
      check_load(load);
    }
  }
  for (const Measure& measure : m_shot.measures) {
    if (sound(measure)) {
      check_measure(measure);
    }
  }
  for (const Expectation& expectation : m_shot.expectations) {
    if (sound(expectation)) {
      check_expectation(expectation);
    }
  }
  check_settings();
}

void Rules::check_region(const Region& region) {
  if (const auto* box = std::get_if<BoxRegion>(&region)) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      if ((*box->min)[i] > (*box->max)[i]) {
        refuse(box->max.source, fmt::format(": along {} the box ends at {} before it begins at {}; swap min and max",
                                            "xyz"[i], (*box->max)[i], (*box->min)[i]));
        return;
      }
    }
  }
  if (const auto* cylinder = std::get_if<CylinderRegion>(&region); cylinder && *cylinder->from == *cylinder->to) {
    refuse(cylinder->to.source, ": both ends of the axis are the same point; a cylinder needs a length");
  }
}

const Material* Rules::material_of(const std::string& body_name) const {
  const Body* body = m_shot.find_body(body_name);
  return body == nullptr ? nullptr : m_shot.find_material(*body->material);
}

void Rules::need_body(const std::string& body, const Source& source) {
  if (body.empty()) {
    refuse(below(source, "body"), fmt::format(" is missing: the shot has {} bodies; name one", m_shot.bodies.size()));
  }
}

void Rules::check_measure(const Measure& measure) {
  need_body(*measure.body, measure.source);
  const bool along_axis = needs_axis(*measure.kind);
  const bool maybe_along_axis =
      along_axis || *measure.kind == MeasureKind::run_out || *measure.kind == MeasureKind::mean_alignment;
  if (*measure.kind == MeasureKind::fraction_outside && !measure.where) {
    refuse(below(measure.source, "where"), " is missing: the part of space that the particles are outside of");
  }
  if (along_axis && !measure.axis) {
    refuse(below(measure.source, "axis"), " is missing: this is measured along or about \"x\", \"y\" or \"z\"");
  }
  if (!maybe_along_axis && measure.axis) {
    refuse(measure.axis->source, ": this kind of measure has no axis; remove it");
  }
  const bool of_grains = *measure.kind == MeasureKind::grains_inside || *measure.kind == MeasureKind::grain_hover;
  const Body* body = m_shot.find_body(*measure.body);
  if (of_grains && body != nullptr && !body->particles.grains) {
    refuse(measure.kind.source, fmt::format(": body '{}' has no sub_particles to be measured", *measure.body));
  }
  if (of_grains && measure.where) {
    refuse(measure.source, ": all grains are measured; remove where");
  }
  if (measure.where) {
    check_region(*measure.where);
  }
}

void Rules::check_expectation(const Expectation& expectation) {
  if (!expectation.min && !expectation.max) {
    refuse(below(expectation.source, "min"), " is missing: give min, max or both; without them nothing is expected");
  }
  if (expectation.frame) {
    check_expected_frame(*expectation.frame);
  }
  if (*expectation.every_frame && expectation.ratio_to) {
    refuse(expectation.every_frame.source, " = true: ratios between wedges are of one frame; remove ratio_to");
  }
  if (expectation.min && expectation.max && **expectation.min > **expectation.max) {
    refuse(expectation.max->source,
           fmt::format(" = {}: expected at least min = {}", **expectation.max, **expectation.min));
  }
}

void Rules::check_expected_frame(const Located<std::int64_t>& frame) {
  const Located<FrameRange>& frames = m_shot.shot.frames;
  const bool cut = frames.source.origin == Origin::command_line && frame.source.origin != Origin::command_line;
  if (cut || m_diagnostics.any_under("shot") || (*frame >= frames->first() && *frame <= frames->last()))
    return;
  refuse(frame.source, fmt::format(" = {}: the shot has frames {} to {}; expected one of them, or longer shot.frames",
                                   *frame, frames->first(), frames->last()));
}

void Rules::check_settings() {
  const FemOptions& fem = m_shot.fem;
  if (fem.time_step && *fem.min_time_step > **fem.time_step && !m_diagnostics.any_under("fem")) {
    refuse(fem.min_time_step.source,
           fmt::format(" = {}: expected at most time_step = {} s", *fem.min_time_step, **fem.time_step));
  }
  if (*fem.rotation_update == RotationUpdate::exponential && *fem.integrator != Integrator::backward_euler) {
    refuse(
        fem.rotation_update.source,
        " = \"exponential\": only backward-euler feels it; bdf2 and sdirk2 count increments from where rotations are "
        "expected, so that both updates are the same to their order; remove it");
  }
  const Camera& camera = m_shot.render.camera;
  if (camera.position && camera.target && **camera.position == **camera.target) {
    refuse(camera.target->source, ": the camera stands where it looks; move target or position");
  }
  for (const HeatRange& range : m_shot.render.heat) {
    if (range.min && range.max && **range.min >= **range.max) {
      refuse(range.max->source, fmt::format(" = {}: expected more than min = {}", **range.max, **range.min));
    }
  }
}

void check_rules(const Shot& shot, Diagnostics& diagnostics) {
  Rules(shot, diagnostics).check();
}

} // namespace wry::shots
