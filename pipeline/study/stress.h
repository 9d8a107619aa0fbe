#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipeline/report/heat_map.h"
#include "pipeline/study/study.h"
#include "shots/ladders.h"

namespace wry::pipeline {

/// One case: a knob at a value, or two knobs at theirs.
struct StressCase {
  std::vector<std::size_t> knobs;  ///< one or two
  std::vector<std::size_t> values; ///< of each
  std::size_t row = 0;             ///< of the study
};

struct StressStudy {
  std::vector<shots::Ladder> knobs;
  std::vector<Variant> variants;
  std::vector<StressCase> cases;
  std::size_t base = 0; ///< the shot as it is
};

/// Whether the shot can be read with this value of a key (TOML).
using AcceptsValue = std::function<bool(const std::string& key, const std::string& value)>;

/// Every value of every knob alone, and (with pairs) the two outermost values of every two knobs together, of those
/// that the shot `accepts`.
StressStudy plan_stress_study(const shots::StressSection& section, const shots::Shot& shot,
                              const AcceptsValue& accepts);

/// The knobs of a shot, those that tell most first.
struct ShotKnobs {
  std::vector<shots::Ladder> knobs;
  std::size_t paired = 0; ///< so many of the first are also turned two at a time
};

/// The knobs that a shot has, each at decades around what the shot says, or at the ends of what is allowed and beyond.
/// Of its solids: stiffness, Poisson's ratio, density, couple modulus, length scale, rest curvature, resolution, time
/// step. Of its particles: stiffness, the ratio of anisotropy, plastic scale, friction angle, density, cell size, time
/// step. Of both: friction, gravity, how fast drives and colliders run through their keys. Bodies that share a material
/// share its knobs; what a method does not read is no knob of its.
ShotKnobs knobs_of(const shots::Shot& shot);

/// A knob's value for people.
std::string value_label(const shots::Ladder& knob, std::size_t value);

/// What came of a case.
struct StressFinding {
  MapMark mark = MapMark::none;
  double slower = 0.0; ///< steps, as a multiple of the shot as it is
  double cuts = 0.0;
  double energy_growth = 0.0; ///< of the total energy over its largest part; positive: it grew
  double least_distance = 0.0;
  std::string message; ///< of a refusal or failure
};

struct StressReport {
  std::vector<StressFinding> findings; ///< per case
  std::vector<std::string> safe;       ///< "material.skin.youngs_modulus: holds from 1e2 to 1e8 (the shot: 5e4)"
  std::size_t failures = 0;            ///< cases that failed ungracefully
};

StressReport judge_stress(const StressStudy& study, const std::vector<StudyRow>& rows);

std::string stress_csv(const StressStudy& study, const std::vector<StudyRow>& rows, const StressReport& report);
/// Knobs down, their values across.
MapPlot stress_map(const StressStudy& study, const StressReport& report, const std::string& shot);
/// Knob against knob, a cell for the four combinations of their ends: the worst of them.
MapPlot stress_pairs_map(const StressStudy& study, const StressReport& report, const std::string& shot);

} // namespace wry::pipeline
