#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "pipeline/report/csv_table.h"
#include "pipeline/study/stress.h"
#include "shots/resolved.h"

namespace wry::pipeline {

namespace {

/// What is turned, by how a key ends, and how far: as multiples of the shot's own value, or as values.
struct KnobRule {
  std::string_view ending;
  std::vector<double> multiples;
  std::vector<double> values;
};

const std::array<KnobRule, 9>& knob_rules() {
  static const std::array<KnobRule, 9> RULES = {{
      {".youngs_modulus", {1e-4, 1e-2, 1e2, 1e4, 1e6}, {}},
      {".poisson_ratio", {}, {-0.9, 0.0, 0.45, 0.49, 0.499, 0.4999, 0.5}},
      {".couple_modulus_ratio", {}, {1e-6, 1e-3, 1e3, 1e6}},
      {".length_scale", {}, {0.0, 1e-9, 1.0, 1e3}},
      {".density", {1e-3, 1e-1, 1e1, 1e3}, {}},
      {".friction", {}, {0.0, 0.5, 1.0, 10.0}},
      {"fem.time_step", {}, {1e-3, 1e-2, 1e-1, 1.0}},
      {".resolution", {0.7, 2.0, 4.0}, {}},
      {"mpm.time_step", {}, {1e-4, 1e-3, 1e-2}},
  }};
  return RULES;
}

std::string number_text(double value) {
  return fmt::format("{:g}", value);
}

std::string name_of(const Variant& variant) {
  std::string text;
  for (const Parameter& parameter : variant.parameters)
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", parameter.key, plain_value(parameter.value));
  return text;
}

std::size_t add_case(StressStudy& study, std::vector<Parameter> parameters) {
  Variant variant = make_variant("", std::move(parameters));
  variant.name = name_of(variant);
  const auto same = std::find_if(study.variants.begin(), study.variants.end(),
                                 [&](const Variant& other) { return other.identity() == variant.identity(); });
  if (same != study.variants.end())
    return static_cast<std::size_t>(same - study.variants.begin());
  study.variants.push_back(std::move(variant));
  return study.variants.size() - 1;
}

/// A value far down and one far up gravity, in the direction that it has.
void add_gravity(const shots::Shot& shot, std::vector<shots::Ladder>& knobs) {
  const Vec3& gravity = *shot.shot.gravity;
  if (gravity.norm() == 0.0)
    return;
  shots::Ladder ladder{"shot.gravity", shot.shot.gravity.source, {}};
  for (const double multiple : {0.0, 10.0, 100.0})
    ladder.values.push_back(
        fmt::format("[{}, {}, {}]", multiple * gravity[0], multiple * gravity[1], multiple * gravity[2]));
  knobs.push_back(std::move(ladder));
}

} // namespace

std::vector<shots::Ladder> knobs_of(const shots::Shot& shot) {
  std::vector<shots::Ladder> knobs;
  for (const shots::FlatKey& key : shots::flatten(shot)) {
    if (key.effect != shots::Effect::simulation)
      continue;
    const auto rule = std::find_if(knob_rules().begin(), knob_rules().end(),
                                   [&](const KnobRule& r) { return key.key.ends_with(r.ending); });
    if (rule == knob_rules().end())
      continue;
    shots::Ladder ladder{key.key, {}, {}};
    const double own = number_of(key.value);
    for (const double multiple : rule->multiples) {
      if (std::isfinite(own))
        ladder.values.push_back(number_text(own * multiple));
    }
    for (const double value : rule->values)
      ladder.values.push_back(number_text(value));
    if (!ladder.values.empty())
      knobs.push_back(std::move(ladder));
  }
  add_gravity(shot, knobs);
  return knobs;
}

StressStudy plan_stress_study(const shots::StressSection& section, const shots::Shot& shot) {
  StressStudy study;
  study.knobs = section.knobs.empty() ? knobs_of(shot) : section.knobs;
  study.base = add_case(study, {});
  study.variants.front().name = "the shot as it is";
  for (std::size_t k = 0; k < study.knobs.size(); ++k) {
    const shots::Ladder& knob = study.knobs[k];
    for (std::size_t v = 0; v < knob.values.size(); ++v)
      study.cases.push_back({{k}, {v}, add_case(study, {{knob.key, knob.values[v]}})});
  }
  for (std::size_t a = 0; section.pairs && a < study.knobs.size(); ++a) {
    for (std::size_t b = a + 1; b < study.knobs.size(); ++b) {
      const shots::Ladder &first = study.knobs[a], &second = study.knobs[b];
      for (const std::size_t i : {std::size_t{0}, first.values.size() - 1}) {
        for (const std::size_t j : {std::size_t{0}, second.values.size() - 1})
          study.cases.push_back(
              {{a, b}, {i, j}, add_case(study, {{first.key, first.values[i]}, {second.key, second.values[j]}})});
      }
    }
  }
  return study;
}

} // namespace wry::pipeline
