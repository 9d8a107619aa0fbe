#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "pipeline/report/csv_table.h"
#include "pipeline/study/accuracy.h"
#include "pipeline/study/accuracy_errors.h"

namespace wry::pipeline {

namespace {

constexpr double NAN_VALUE = std::numeric_limits<double>::quiet_NaN();

/// Judges the runs of one accuracy study.
class Judge {
public:
  Judge(const shots::AccuracySection& section, const AccuracyStudy& plan, const std::vector<StudyRow>& rows,
        Compared compared)
      : m_section(section)
      , m_plan(plan)
      , m_rows(rows)
      , m_compared(compared) {}

  AccuracyReport judge() {
    find_quantities();
    for (const Rung& rung : m_plan.rungs) {
      if (!rung.is_reference)
        m_report.rungs.push_back(judged(rung));
    }
    drop_empty_quantities();
    for (std::size_t ladder = 0; ladder < m_section.ladders.size(); ++ladder) {
      for (std::size_t q = 0; q < m_report.quantities.size(); ++q)
        m_report.verdicts.push_back(verdict(ladder, q));
    }
    if (!m_report.quantities.empty())
      advise();
    return std::move(m_report);
  }

private:
  void find_quantities() {
    if (m_compared == Compared::pictures) {
      m_report.quantities = {"picture"};
      return;
    }
    for (const auto& [name, value] : m_section.exact)
      m_report.quantities.push_back(name);
    if (!m_report.quantities.empty() && m_section.reference.empty())
      return;
    for (const StudyRow& row : m_rows) {
      for (const auto& [name, value] : row.measures) {
        const bool known =
            std::find(m_report.quantities.begin(), m_report.quantities.end(), name) != m_report.quantities.end();
        if (!known && name != "frame" && name != "time_s")
          m_report.quantities.push_back(name);
      }
    }
    for (const ErrorValue& value : errors_of_frames({}, {}))
      m_report.quantities.push_back(value.quantity);
  }

  /// What no rung has, such as rotations of a classic solid.
  void drop_empty_quantities() {
    for (std::size_t q = m_report.quantities.size(); q-- > 0;) {
      const bool any = std::any_of(m_report.rungs.begin(), m_report.rungs.end(),
                                   [&](const JudgedRung& rung) { return std::isfinite(rung.errors[q].error); });
      if (any)
        continue;
      m_report.quantities.erase(m_report.quantities.begin() + static_cast<std::ptrdiff_t>(q));
      for (JudgedRung& rung : m_report.rungs)
        rung.errors.erase(rung.errors.begin() + static_cast<std::ptrdiff_t>(q));
    }
  }

  const Rung* reference_of(std::size_t ladder) const {
    const auto found = std::find_if(m_plan.rungs.begin(), m_plan.rungs.end(),
                                    [&](const Rung& rung) { return rung.ladder == ladder && rung.is_reference; });
    return found == m_plan.rungs.end() ? nullptr : &*found;
  }

  std::string name_of(const Rung& rung) const {
    if (rung.row != m_plan.base)
      return m_rows[rung.row].variant.name;
    const shots::Ladder& ladder = m_section.ladders[rung.ladder];
    return fmt::format("{} = {}, as it is", ladder.key, plain_value(ladder.values[rung.step]));
  }

  JudgedRung judged(const Rung& rung) const {
    const StudyRow& row = m_rows[rung.row];
    JudgedRung result{rung,
                      name_of(rung),
                      std::string(outcome_name(row.outcome)),
                      row.cpu_seconds,
                      row.wall_seconds,
                      row.timing_spread,
                      0.0,
                      0.0,
                      {}};
    const CsvTable stats = read_csv_table(row.folder / "stats.csv");
    result.steps = static_cast<double>(stats.rows.size());
    for (const double iterations : stats.numbers("newton_iterations"))
      result.iterations += iterations;
    const Rung* reference = reference_of(rung.ladder);
    const StudyRow* exact = reference != nullptr ? &m_rows[reference->row] : nullptr;
    if (row.outcome != StudyOutcome::done)
      result.outcome += ": " + row.reason;
    else if (exact != nullptr && exact->outcome != StudyOutcome::done)
      result.outcome = "its reference is not done: " + exact->reason;
    const bool comparable = result.outcome == "done";
    std::vector<ErrorValue> nodes;
    if (comparable && exact != nullptr && m_compared == Compared::pictures)
      nodes = {{"picture", picture_error(row, *exact)}};
    else if (comparable && exact != nullptr)
      nodes = errors_of_frames(row, *exact);
    for (const std::string& quantity : m_report.quantities)
      result.errors.push_back({quantity, comparable ? error_of(row, exact, nodes, quantity) : NAN_VALUE});
    return result;
  }

  double error_of(const StudyRow& row, const StudyRow* exact, const std::vector<ErrorValue>& nodes,
                  const std::string& quantity) const {
    for (const auto& [name, value] : m_section.exact) {
      if (name == quantity)
        return exact_error(row, name, value);
    }
    for (const ErrorValue& value : nodes) {
      if (value.quantity == quantity)
        return value.error;
    }
    return exact != nullptr ? measure_error(row, *exact, quantity) : NAN_VALUE;
  }

  LadderVerdict verdict(std::size_t ladder, std::size_t q) const {
    LadderVerdict result{m_section.ladders[ladder].key, m_report.quantities[q], NAN_VALUE, {}};
    std::vector<double> values, errors;
    bool falling = true;
    for (const JudgedRung& judged : m_report.rungs) {
      if (judged.rung.ladder != ladder || !std::isfinite(judged.errors[q].error))
        continue;
      const double error = judged.errors[q].error;
      if (falling && !errors.empty() && error > 0.8 * errors.back()) {
        falling = false;
        result.remarks.push_back(
            fmt::format("refining no longer helps at {}: {:.2g} after {:.2g}", judged.name, error, errors.back()));
      }
      if (!falling)
        continue;
      values.push_back(judged.rung.value);
      errors.push_back(error);
    }
    result.observed_order = observed_order(values, errors);
    judge_reference(ladder, values, result);
    return result;
  }

  /// The error that is left in a reference finer by f is about f^-order of the finest rung's.
  void judge_reference(std::size_t ladder, const std::vector<double>& values, LadderVerdict& result) const {
    const Rung* reference = reference_of(ladder);
    if (reference == nullptr || values.empty() || !std::isfinite(result.observed_order))
      return;
    const double finest = values.back();
    if (!std::isfinite(reference->value)) {
      if (std::none_of(m_section.reference.begin(), m_section.reference.end(),
                       [&](const shots::Override& o) { return o.key == m_section.ladders[ladder].key; }))
        result.remarks.push_back("the reference does not refine this key: its own error is in all of these");
      return;
    }
    const double factor = std::max(finest / reference->value, reference->value / finest);
    const double left = std::pow(factor, -std::abs(result.observed_order));
    if (left > 0.3)
      result.remarks.push_back(
          fmt::format("the reference is not finer enough to judge the last rung: about {:.0f} % of "
                      "its error would be the reference's own",
                      100.0 * left));
  }

  /// What two times may differ by and yet be the same: as far as repeats lie apart, if there are any.
  double timing_noise() const {
    double spread = 0.0;
    for (const JudgedRung& judged : m_report.rungs)
      spread = std::max(spread, judged.timing_spread);
    return m_section.repeats > 1 ? spread : TIMING_NOISE;
  }

  /// Errors against different references do not compare: a ladder with a reference of its own gets its own advice.
  void advise() {
    std::map<std::size_t, std::vector<std::size_t>> by_reference;
    for (std::size_t i = 0; i < m_report.rungs.size(); ++i) {
      const Rung* reference = reference_of(m_report.rungs[i].rung.ladder);
      by_reference[reference != nullptr ? reference->row : m_rows.size()].push_back(i);
    }
    for (const auto& [reference, rungs] : by_reference)
      advise(rungs);
  }

  /// What the shot as it is takes and errs by, beside the rung that is recommended.
  void compare_with_base(const JudgedRung& best, const std::vector<std::size_t>& rungs, double noise) {
    const StudyRow& base = m_rows[m_plan.base];
    if (best.rung.row == m_plan.base || base.outcome != StudyOutcome::done || !(best.cpu_seconds > 0.0))
      return;
    const double ratio = base.cpu_seconds / best.cpu_seconds;
    std::string words = fmt::format("the shot as it is takes {:.3g} s, ", base.cpu_seconds);
    words += std::abs(ratio - 1.0) <= noise ? std::string("as long within what timings vary by")
                                            : fmt::format("{:.2g} times as long", ratio);
    const auto own = std::find_if(rungs.begin(), rungs.end(),
                                  [&](std::size_t i) { return m_report.rungs[i].rung.row == m_plan.base; });
    if (own != rungs.end() && std::isfinite(m_report.rungs[*own].errors.front().error))
      words += fmt::format(" (error {:.2g} %)", 100.0 * m_report.rungs[*own].errors.front().error);
    m_report.advice.push_back(words);
  }

  void advise(const std::vector<std::size_t>& rungs) {
    std::vector<double> times(m_report.rungs.size(), NAN_VALUE), errors(m_report.rungs.size(), NAN_VALUE);
    const double noise = timing_noise();
    for (const std::size_t i : rungs) {
      times[i] = m_report.rungs[i].cpu_seconds;
      errors[i] = m_report.rungs[i].errors.front().error;
    }
    const std::vector<std::size_t> front = pareto_front(times, errors);
    m_report.front.insert(m_report.front.end(), front.begin(), front.end());
    const std::string& quantity = m_report.quantities.front();
    const auto good =
        std::find_if(front.begin(), front.end(), [&](std::size_t i) { return errors[i] <= m_section.tolerance; });
    if (good == front.end()) {
      m_report.advice.push_back(
          fmt::format("no rung reaches {:g} % of {}; {}", 100.0 * m_section.tolerance, quantity,
                      front.empty() ? std::string("none could be judged")
                                    : fmt::format("the best is {} with {:.2g} %", m_report.rungs[front.back()].name,
                                                  100.0 * errors[front.back()])));
      return;
    }
    const JudgedRung& best = m_report.rungs[*good];
    m_report.advice.push_back(fmt::format("for {:g} % of {}: {}, {:.3g} s of CPU (error {:.2g} %)",
                                          100.0 * m_section.tolerance, quantity, best.name, best.cpu_seconds,
                                          100.0 * errors[*good]));
    compare_with_base(best, rungs, noise);
    for (std::size_t i = 0; i < times.size(); ++i) {
      const bool close = i != *good && errors[i] <= m_section.tolerance && times[i] < times[*good] * (1.0 + noise);
      if (close)
        m_report.advice.push_back(fmt::format("{} is as fast within the {:.2g} % that timings vary by",
                                              m_report.rungs[i].name, 100.0 * noise));
    }
  }

  const shots::AccuracySection& m_section;
  const AccuracyStudy& m_plan;
  const std::vector<StudyRow>& m_rows;
  Compared m_compared;
  AccuracyReport m_report;
};

} // namespace

AccuracyReport judge_accuracy(const shots::AccuracySection& section, const AccuracyStudy& plan,
                              const std::vector<StudyRow>& rows, Compared compared) {
  return Judge(section, plan, rows, compared).judge();
}

} // namespace wry::pipeline
