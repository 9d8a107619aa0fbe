#include "pipeline/study/accuracy.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "pipeline/report/csv_table.h"
#include "shots/tree.h"

namespace wry::pipeline {

namespace {

/// Adds a variant, or finds the one that is the same.
std::size_t add_variant(std::vector<Variant>& variants, Variant variant) {
  const auto same = std::find_if(variants.begin(), variants.end(),
                                 [&](const Variant& other) { return other.identity() == variant.identity(); });
  if (same != variants.end())
    return static_cast<std::size_t>(same - variants.begin());
  variants.push_back(std::move(variant));
  return variants.size() - 1;
}

/// The value beyond the finest rung: further the way that the ladder goes.
Result<std::string> finer_value(const shots::Ladder& ladder, double factor) {
  const double first = number_of(ladder.values.front()), last = number_of(ladder.values.back());
  if (ladder.values.size() < 2 || !std::isfinite(first) || !std::isfinite(last) || first == last || last == 0.0)
    return make_error(
        ErrorCode::bad_input,
        "{}: a reference cannot be made from these values; list at least two numbers from coarse to fine, "
        "or give accuracy.reference",
        ladder.source.text());
  const double finer = std::abs(last) < std::abs(first) ? last / factor : last * factor;
  const bool whole = ladder.values.back().find_first_of(".eE") == std::string::npos;
  return whole ? std::to_string(std::llround(finer)) : shots::to_toml(finer);
}

} // namespace

Result<AccuracyStudy> plan_accuracy_study(const shots::AccuracySection& section, const HasValue& has) {
  AccuracyStudy study;
  study.base = add_variant(study.variants, make_variant("the shot as it is", {}));
  std::vector<Parameter> common;
  for (const shots::Override& override_ : section.reference)
    common.push_back({override_.key, override_.value});
  for (std::size_t l = 0; l < section.ladders.size(); ++l) {
    const shots::Ladder& ladder = section.ladders[l];
    for (std::size_t step = 0; step < ladder.values.size(); ++step) {
      const std::string& value = ladder.values[step];
      const std::size_t row =
          has(ladder.key, value)
              ? study.base
              : add_variant(study.variants, make_variant(fmt::format("{} = {}", ladder.key, plain_value(value)),
                                                         {{ladder.key, value}}));
      study.rungs.push_back({l, step, number_of(value), false, row});
    }
    if (!section.exact.empty() && section.reference.empty())
      continue;
    std::vector<Parameter> reference = common;
    if (reference.empty()) {
      const Result<std::string> finer = finer_value(ladder, section.reference_factor);
      if (!finer)
        return finer.error();
      reference = {{ladder.key, *finer}};
    }
    std::string name = "reference";
    for (const Parameter& parameter : reference)
      name += fmt::format(" {} = {}", parameter.key, plain_value(parameter.value));
    double value = std::numeric_limits<double>::quiet_NaN();
    for (const Parameter& parameter : reference)
      value = parameter.key == ladder.key ? number_of(parameter.value) : value;
    study.rungs.push_back(
        {l, ladder.values.size(), value, true, add_variant(study.variants, make_variant(name, std::move(reference)))});
  }
  return study;
}

SplitLadders split_ladders(const shots::AccuracySection& section) {
  const auto is_drawn = [](const auto& entry) { return entry.key.starts_with("render."); };
  SplitLadders split{section, section};
  std::erase_if(split.simulated.ladders, is_drawn);
  std::erase_if(split.simulated.reference, is_drawn);
  std::erase_if(split.drawn.ladders, [&](const shots::Ladder& ladder) { return !is_drawn(ladder); });
  std::erase_if(split.drawn.reference, [&](const shots::Override& value) { return !is_drawn(value); });
  split.drawn.exact.clear();
  return split;
}

double observed_order(const std::vector<double>& values, const std::vector<double>& errors) {
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t i = 0; i < std::min(values.size(), errors.size()); ++i) {
    if (!(values[i] > 0.0) || !(errors[i] > 0.0) || !std::isfinite(errors[i]))
      continue;
    const double x = std::log(values[i]), y = std::log(errors[i]);
    n += 1.0;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  const double spread = n * sxx - sx * sx;
  return n >= 2.0 && spread > 1e-12 ? (n * sxy - sx * sy) / spread : std::numeric_limits<double>::quiet_NaN();
}

std::vector<std::size_t> pareto_front(const std::vector<double>& times, const std::vector<double>& errors) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < std::min(times.size(), errors.size()); ++i) {
    if (std::isfinite(times[i]) && std::isfinite(errors[i]))
      order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return times[a] != times[b] ? times[a] < times[b] : errors[a] < errors[b];
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order) {
    if (front.empty() || errors[i] < errors[front.back()])
      front.push_back(i);
  }
  return front;
}

std::string accuracy_csv(const AccuracyReport& report) {
  std::string text = "rung,value,outcome,cpu_s,wall_s,steps,iterations,on_front";
  for (const std::string& quantity : report.quantities)
    text += "," + quantity + "_error";
  text += "\n";
  for (std::size_t i = 0; i < report.rungs.size(); ++i) {
    const JudgedRung& judged = report.rungs[i];
    const bool front = std::find(report.front.begin(), report.front.end(), i) != report.front.end();
    std::string outcome = judged.outcome;
    std::replace(outcome.begin(), outcome.end(), '"', '\'');
    text += fmt::format("\"{}\",{},\"{}\",{:.4f},{:.4f},{:g},{:g},{}", judged.name, judged.rung.value, outcome,
                        judged.cpu_seconds, judged.wall_seconds, judged.steps, judged.iterations, front ? 1 : 0);
    for (const ErrorValue& value : judged.errors)
      text += fmt::format(",{}", value.error);
    text += "\n";
  }
  return text;
}

std::vector<Plot> accuracy_plots(const shots::AccuracySection& section, const AccuracyReport& report) {
  std::vector<Plot> plots;
  for (std::size_t q = 0; q < report.quantities.size(); ++q) {
    Plot time{fmt::format("Error of {} against run time", report.quantities[q]),
              "CPU time [s]",
              "relative error",
              PlotScale::logarithmic,
              PlotScale::logarithmic,
              {},
              860,
              460};
    for (std::size_t l = 0; l < section.ladders.size(); ++l) {
      PlotSeries over_key{"measured", {}, {}, PlotMark::line_and_points, {}};
      PlotSeries over_time{section.ladders[l].key, {}, {}, PlotMark::line_and_points, {}};
      for (const JudgedRung& judged : report.rungs) {
        if (judged.rung.ladder != l)
          continue;
        over_key.x.push_back(judged.rung.value);
        over_key.y.push_back(judged.errors[q].error);
        over_time.x.push_back(judged.cpu_seconds);
        over_time.y.push_back(judged.errors[q].error);
        over_time.point_labels.push_back(std::isfinite(judged.rung.value)
                                             ? fmt::format("{:.3g}", judged.rung.value)
                                             : judged.name.substr(judged.name.rfind(' ') + 1));
      }
      time.series.push_back(over_time);
      Plot ladder{fmt::format("Error of {} over {}", report.quantities[q], section.ladders[l].key),
                  section.ladders[l].key,
                  "relative error",
                  PlotScale::logarithmic,
                  PlotScale::logarithmic,
                  {over_key},
                  560,
                  340};
      for (const int order : {1, 2}) {
        PlotSeries slope{fmt::format("order {}", order), {}, {}, PlotMark::dashed, {}};
        for (std::size_t i = 0; i < over_key.x.size(); ++i) {
          slope.x.push_back(over_key.x[i]);
          slope.y.push_back(over_key.y.front() * std::pow(over_key.x[i] / over_key.x.front(), order));
        }
        if (std::isfinite(section.ladders[l].values.size() > 1 ? number_of(section.ladders[l].values[0]) : NAN))
          ladder.series.push_back(std::move(slope));
      }
      plots.push_back(std::move(ladder));
    }
    plots.insert(plots.begin() + static_cast<std::ptrdiff_t>(q), std::move(time));
  }
  return plots;
}

} // namespace wry::pipeline
