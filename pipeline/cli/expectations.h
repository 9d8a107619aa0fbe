#pragma once

#include <string>
#include <vector>

#include "pipeline/run/measure_frames.h"
#include "shots/shot.h"

namespace wry::pipeline {

/// What came of one [expect.X] in one run.
struct Judgement {
  enum class Verdict { holds, fails, not_judged } verdict = Verdict::not_judged;
  std::string name;
  std::string why; ///< of what fails: place, value, range; of what is not judged: the reason
};

/// Every expectation that is about this run's case, against what was measured. One about a frame that was not asked
/// for, or about the ratio between wedges, is not judged.
std::vector<Judgement> judge_expectations(const shots::Shot& shot, const MeasureTable& table);

/// Prints how many hold and which are not judged. Error: check_failed with all that fail.
Status report_judgements(const std::vector<Judgement>& judgements);

/// The frame that an expectation is about, or from which on it is: its own, or the last of the shot (the first of
/// every_frame).
int expected_frame(const shots::Expectation& expectation, const shots::Shot& shot);

/// "frame 28 was not asked for"
std::string not_asked_for(int frame);

} // namespace wry::pipeline
