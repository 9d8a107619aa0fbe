#include "pipeline/cli/expectations.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace wry::pipeline {

namespace {

using Verdict = Judgement::Verdict;

bool is_about_this_case(const shots::Expectation& expectation, const shots::Shot& shot) {
  if (!expectation.sweep_case)
    return true;
  return shot.sweep_case && **shot.sweep_case == **expectation.sweep_case;
}

/// How far a value lies out of the range; negative: within.
double excess_of(const shots::Expectation& expectation, double value) {
  if (std::isnan(value))
    return std::numeric_limits<double>::infinity();
  double excess = -1.0;
  if (expectation.min && value < **expectation.min)
    excess = **expectation.min - value;
  if (expectation.max && value > **expectation.max)
    excess = value - **expectation.max;
  return excess;
}

std::string failure(const shots::Expectation& expectation, double value, int frame) {
  const bool low = expectation.min && !(value >= **expectation.min);
  const std::string found = std::isnan(value) ? "not a number" : fmt::format("{:.6g}", value);
  return fmt::format("{}: {} is {} at frame {}, expected {} {:.6g}", expectation.source.text(), *expectation.measure,
                     found, frame, low ? "at least" : "at most", low ? **expectation.min : **expectation.max);
}

/// The worst of its frames decides.
Judgement judge(const shots::Expectation& expectation, const shots::Shot& shot, const MeasureTable& table) {
  if (expectation.ratio_to)
    return {Verdict::not_judged, *expectation.name, "it is between wedges: wry sweep judges it"};
  const int from = expected_frame(expectation, shot);
  const auto name = std::find(table.names.begin(), table.names.end(), *expectation.measure);
  const auto column = static_cast<std::size_t>(name - table.names.begin());
  Judgement judgement{Verdict::not_judged, *expectation.name, not_asked_for(from)};
  double worst = -1.0;
  for (std::size_t row = 0; row < table.frames.size() && name != table.names.end(); ++row) {
    if (table.frames[row] < from || (!*expectation.every_frame && table.frames[row] != from))
      continue;
    const double value = table.rows[row][column], excess = excess_of(expectation, value);
    if (judgement.verdict == Verdict::not_judged)
      judgement = {Verdict::holds, *expectation.name, {}};
    if (excess <= worst)
      continue;
    worst = excess;
    judgement = {Verdict::fails, *expectation.name, failure(expectation, value, table.frames[row])};
  }
  return judgement;
}

} // namespace

int expected_frame(const shots::Expectation& expectation, const shots::Shot& shot) {
  if (expectation.frame)
    return static_cast<int>(**expectation.frame);
  return *expectation.every_frame ? shot.shot.frames->first() : shot.shot.frames->last();
}

std::string not_asked_for(int frame) {
  return fmt::format("frame {} was not asked for", frame);
}

std::vector<Judgement> judge_expectations(const shots::Shot& shot, const MeasureTable& table) {
  std::vector<Judgement> judgements;
  for (const shots::Expectation& expectation : shot.expectations) {
    if (is_about_this_case(expectation, shot))
      judgements.push_back(judge(expectation, shot, table));
  }
  return judgements;
}

Status report_judgements(const std::vector<Judgement>& judgements) {
  const auto count = [&](Verdict verdict) {
    return std::count_if(judgements.begin(), judgements.end(),
                         [&](const Judgement& judgement) { return judgement.verdict == verdict; });
  };
  std::string failed;
  if (const auto hold = count(Verdict::holds); hold > 0)
    fmt::print("{} expectations hold\n", hold);
  for (const Judgement& judgement : judgements) {
    if (judgement.verdict == Verdict::not_judged)
      fmt::print("not judged: {} ({})\n", judgement.name, judgement.why);
    else if (judgement.verdict == Verdict::fails)
      failed += "\n  " + judgement.why;
  }
  if (!failed.empty())
    return make_error(ErrorCode::check_failed, "expectations that do not hold:{}", failed);
  return {};
}

} // namespace wry::pipeline
