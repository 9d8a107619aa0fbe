#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/report/plot.h"
#include "pipeline/study/accuracy_errors.h"
#include "pipeline/study/study.h"
#include "shots/ladders.h"

namespace wry::pipeline {

/// One rung: a variant of the study with its place on a ladder.
struct Rung {
  std::size_t ladder = 0;
  std::size_t step = 0;      ///< 0 is the coarsest
  double value = 0.0;        ///< NaN when the key's values are no numbers
  bool is_reference = false; ///< held against, not judged
  std::size_t row = 0;       ///< of the study
};

/// Which variants an accuracy study runs: every rung of every ladder, their references, and the shot as it is. Variants
/// that would be the same are run once.
struct AccuracyStudy {
  std::vector<Variant> variants;
  std::vector<Rung> rungs;
  std::size_t base = 0; ///< the shot as it is
};

/// Whether the shot has this value of a key (TOML) anyway.
using HasValue = std::function<bool(const std::string& key, const std::string& value)>;

/// A rung at the value that the shot `has` is the shot as it is. Errors: bad_input for a ladder whose reference cannot
/// be made finer by a factor (words, or one value).
Result<AccuracyStudy> plan_accuracy_study(const shots::AccuracySection& section, const HasValue& has);

struct JudgedRung {
  Rung rung;
  std::string name;                             ///< "fem.time_step = 0.02"
  std::string outcome;                          ///< "done", or why there is no error
  double cpu_seconds = 0.0, wall_seconds = 0.0; ///< the median of repeats
  double timing_spread = 0.0;                   ///< largest CPU time less the least, over the median
  double steps = 0.0, iterations = 0.0;
  std::vector<ErrorValue> errors;
};

/// What a ladder tells about one quantity.
struct LadderVerdict {
  std::string key, quantity;
  double observed_order = std::numeric_limits<double>::quiet_NaN(); ///< over the rungs before the error stops falling
  std::vector<std::string> remarks; ///< "the reference is not finer enough ...", "refining no longer helps ..."
};

struct AccuracyReport {
  std::vector<std::string> quantities;
  std::vector<JudgedRung> rungs; ///< references left out
  std::vector<LadderVerdict> verdicts;
  std::vector<std::size_t> front;  ///< Pareto fronts over the first quantity, one per reference, cheapest first
  std::vector<std::string> advice; ///< in words
};

/// The ladders of a section over what is simulated, and those over how it is drawn (render.*), whose rungs draw the
/// frames of the shot as it is. References go to the part that their keys belong to.
struct SplitLadders {
  shots::AccuracySection simulated, drawn;
};
SplitLadders split_ladders(const shots::AccuracySection& section);

/// What the runs of a study are held against each other by.
enum class Compared { frames, pictures };

/// Reads the runs of an accuracy study and judges them. Timing differences below what repeats
/// differ by, or without repeats below `TIMING_NOISE`, are said to be none.
AccuracyReport judge_accuracy(const shots::AccuracySection& section, const AccuracyStudy& plan,
                              const std::vector<StudyRow>& rows, Compared compared = Compared::frames);
inline constexpr double TIMING_NOISE = 0.1;

/// A row per rung.
std::string accuracy_csv(const AccuracyReport& report);
/// Error over each ladder's key, and error over time with the front.
std::vector<Plot> accuracy_plots(const shots::AccuracySection& section, const AccuracyReport& report);

/// Slope of log(error) over log(value) by least squares; NaN with fewer than two points.
double observed_order(const std::vector<double>& values, const std::vector<double>& errors);
/// Indices of points that no other beats in both time and error, by time.
std::vector<std::size_t> pareto_front(const std::vector<double>& times, const std::vector<double>& errors);

} // namespace wry::pipeline
