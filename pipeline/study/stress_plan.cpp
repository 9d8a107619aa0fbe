#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "pipeline/report/csv_table.h"
#include "pipeline/study/stress.h"

namespace wry::pipeline {

namespace {

/// "density = 10, friction = 0.5"
std::string name_of(const std::vector<shots::Ladder>& knobs, const StressCase& one) {
  std::string text;
  for (std::size_t i = 0; i < one.knobs.size(); ++i)
    text += fmt::format("{}{} = {}", i == 0 ? "" : ", ", knobs[one.knobs[i]].key,
                        value_label(knobs[one.knobs[i]], one.values[i]));
  return text;
}

/// The row of the study that runs these values, added where no other case has them.
std::size_t row_of(StressStudy& study, const StressCase& one) {
  std::vector<Parameter> parameters;
  for (std::size_t i = 0; i < one.knobs.size(); ++i)
    parameters.push_back({study.knobs[one.knobs[i]].key, study.knobs[one.knobs[i]].values[one.values[i]]});
  Variant variant = make_variant("", std::move(parameters));
  variant.name = one.knobs.empty() ? "the shot as it is" : name_of(study.knobs, one);
  const auto same = std::find_if(study.variants.begin(), study.variants.end(),
                                 [&](const Variant& other) { return other.identity() == variant.identity(); });
  if (same != study.variants.end())
    return static_cast<std::size_t>(same - study.variants.begin());
  study.variants.push_back(std::move(variant));
  return study.variants.size() - 1;
}

void add_case(StressStudy& study, StressCase one) {
  one.row = row_of(study, one);
  study.cases.push_back(std::move(one));
}

/// The outermost values of a knob that the shot takes by themselves: what is refused alone tells nothing of a pair.
std::vector<std::size_t> ends_of(const shots::Ladder& knob, const AcceptsValue& accepts) {
  std::vector<std::size_t> taken;
  for (std::size_t v = 0; v < knob.values.size(); ++v) {
    if (accepts(knob.key, knob.values[v]))
      taken.push_back(v);
  }
  if (taken.size() > 2)
    taken = {taken.front(), taken.back()};
  return taken;
}

} // namespace

std::string value_label(const shots::Ladder& knob, std::size_t value) {
  if (!knob.labels.empty())
    return knob.labels[value];
  const double number = number_of(knob.values[value]);
  return std::isfinite(number) ? fmt::format("{:.5g}", number) : plain_value(knob.values[value]);
}

StressStudy plan_stress_study(const shots::StressSection& section, const shots::Shot& shot,
                              const AcceptsValue& accepts) {
  StressStudy study;
  std::size_t paired = 0;
  if (section.knobs.empty()) {
    ShotKnobs knobs = knobs_of(shot);
    paired = knobs.paired;
    study.knobs = std::move(knobs.knobs);
  } else {
    study.knobs = section.knobs;
    paired = study.knobs.size();
  }
  study.base = row_of(study, {});
  for (std::size_t k = 0; k < study.knobs.size(); ++k) {
    for (std::size_t v = 0; v < study.knobs[k].values.size(); ++v)
      add_case(study, {{k}, {v}, 0});
  }
  if (!section.pairs)
    return study;
  std::vector<std::vector<std::size_t>> ends;
  for (std::size_t k = 0; k < paired; ++k)
    ends.push_back(ends_of(study.knobs[k], accepts));
  for (std::size_t a = 0; a < paired; ++a) {
    for (std::size_t b = a + 1; b < paired; ++b) {
      for (const std::size_t i : ends[a]) {
        for (const std::size_t j : ends[b])
          add_case(study, {{a, b}, {i, j}, 0});
      }
    }
  }
  return study;
}

} // namespace wry::pipeline
