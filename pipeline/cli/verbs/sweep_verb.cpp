#include <algorithm>
#include <filesystem>
#include <limits>

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cli/output_folder.h"
#include "pipeline/cli/shot_session.h"
#include "pipeline/cli/verb.h"
#include "pipeline/report/csv.h"
#include "shots/load.h"
#include "shots/sweep.h"

namespace wry::pipeline {

namespace {

namespace fs = std::filesystem;

struct WedgeRun {
  shots::Wedge wedge;
  fs::path out;
  int exit_code = 0;
  /// Last row of its measure.csv, by column.
  std::vector<std::pair<std::string, std::string>> measures;
};

std::vector<std::string> arguments_of(const WedgeRun& run, const Invocation& invocation) {
  std::vector<std::string> words = {"run", invocation.subject};
  for (const std::string& text : invocation.sets)
    words.insert(words.end(), {"--set", text});
  for (const shots::Override& override_ : run.wedge.overrides) {
    if (override_.key == "case")
      words.insert(words.end(), {"--case", override_.value});
    else
      words.insert(words.end(), {"--set", override_.key + "=" + override_.value});
  }
  words.insert(words.end(), {"--out", run.out.string(), "--isa", invocation.isa, "--gl", invocation.gl});
  if (!invocation.frames.empty())
    words.insert(words.end(), {"--frames", invocation.frames});
  if (invocation.threads > 0)
    words.insert(words.end(), {"--threads", std::to_string(invocation.threads)});
  if (invocation.fresh)
    words.push_back("--fresh");
  words.push_back("--quiet");
  return words;
}

void read_last_measures(WedgeRun& run) {
  const Result<std::string> text = read_whole_file(run.out / "measure.csv");
  if (!text)
    return;
  std::vector<std::string> lines;
  std::size_t begin = 0;
  while (begin < text->size()) {
    const std::size_t end = std::min(text->find('\n', begin), text->size());
    lines.push_back(text->substr(begin, end - begin));
    begin = end + 1;
  }
  if (lines.size() < 2)
    return;
  const std::vector<std::string> names = split_csv_line(lines.front());
  const std::vector<std::string> values = split_csv_line(lines.back());
  for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i)
    run.measures.emplace_back(names[i], values[i]);
}

const std::string* find_measure(const WedgeRun& run, const std::string& name) {
  for (const auto& [column, value] : run.measures) {
    if (column == name)
      return &value;
  }
  return nullptr;
}

/// Ratios between wedges, which no single wedge can hold against its expectation.
Status check_ratios(const shots::Shot& shot, const std::vector<WedgeRun>& runs) {
  std::string failed;
  const auto value_in = [&](const std::string& wedge, const std::string& measure) {
    for (const WedgeRun& run : runs) {
      if (run.wedge.name != wedge)
        continue;
      if (const std::string* value = find_measure(run, measure))
        return std::stod(*value);
    }
    return std::numeric_limits<double>::quiet_NaN();
  };
  for (const shots::Expectation& expectation : shot.expectations) {
    if (!expectation.ratio_to || !expectation.sweep_case)
      continue;
    const double ratio = value_in(**expectation.sweep_case, *expectation.measure) /
                         value_in(**expectation.ratio_to, *expectation.measure);
    if ((expectation.min && !(ratio >= **expectation.min)) || (expectation.max && !(ratio <= **expectation.max)))
      failed += fmt::format("\n  {}: {} of {} over {} is {:.4g}", expectation.source.text(), *expectation.measure,
                            **expectation.sweep_case, **expectation.ratio_to, ratio);
  }
  if (!failed.empty())
    return make_error(ErrorCode::check_failed, "expectations between wedges that do not hold:{}", failed);
  return {};
}

std::string table_csv(const std::vector<WedgeRun>& runs) {
  std::string text = "wedge,name,exit_code";
  const auto widest = std::max_element(runs.begin(), runs.end(), [](const WedgeRun& a, const WedgeRun& b) {
    return a.measures.size() < b.measures.size();
  });
  for (const auto& [column, value] : widest->measures)
    text += "," + csv_field(column);
  text += "\n";
  for (const WedgeRun& run : runs) {
    text += fmt::format("{},{},{}", run.wedge.id(), csv_field(run.wedge.name), run.exit_code);
    for (const auto& [column, ignored] : widest->measures) {
      const std::string* value = find_measure(run, column);
      text += "," + (value != nullptr ? *value : std::string());
    }
    text += "\n";
  }
  return text;
}

} // namespace

Status sweep_verb(const Invocation& invocation) {
  const Result<ShotSession> session = open_session(invocation);
  if (!session)
    return session.error();
  const Result<shots::ShotDocument> document = shots::read_document(invocation.subject);
  if (!document)
    return document.error();
  const Result<std::vector<shots::Wedge>> wedges = shots::expand_sweep(*document);
  if (!wedges)
    return wedges.error();
  if (wedges->empty())
    return make_error(ErrorCode::bad_input, "{} has no [sweep]", invocation.subject);
  std::vector<WedgeRun> runs;
  for (const shots::Wedge& wedge : *wedges)
    runs.push_back({wedge, session->out / "wedges" / wedge.id(), 0, {}});
  if (invocation.dry_run) {
    for (const WedgeRun& run : runs)
      fmt::print("{}  {}\n", run.wedge.id(), run.wedge.name);
    return {};
  }
  const Result<FolderLock> lock = take_folder(session->out);
  if (!lock)
    return lock.error();
  int failures = 0;
  for (WedgeRun& run : runs) {
    if (!invocation.quiet)
      fmt::print("wedge {}: {}\n", run.wedge.id(), run.wedge.name);
    std::fflush(stdout);
    const Result<std::vector<ChildOutcome>> outcome = run_self({arguments_of(run, invocation)});
    if (!outcome)
      return outcome.error();
    run.exit_code = outcome->front().exit_code;
    if (run.exit_code == static_cast<int>(ErrorCode::stopped))
      return make_error(ErrorCode::stopped, "stopped in wedge {}; the same command goes on from there", run.wedge.id());
    failures += run.exit_code == 0 ? 0 : 1;
    read_last_measures(run);
  }
  const std::string table = table_csv(runs);
  if (Status status = write_file_atomically(session->out / "sweep.csv", table); !status)
    return status;
  if (!invocation.quiet)
    fmt::print("{}table: {}\n", table, (session->out / "sweep.csv").string());
  if (failures > 0)
    return make_error(ErrorCode::check_failed, "{} of {} wedges failed; their messages are above", failures,
                      runs.size());
  return check_ratios(session->shot, runs);
}

} // namespace wry::pipeline
