#include "pipeline/cli/run_report.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/plan/build_id.h"
#include "pipeline/report/html.h"
#include "pipeline/report/readable.h"
#include "pipeline/report/run_plots.h"
#include "pipeline/run/render_frames.h"
#include "render/contact_sheet.h"
#include "render/png.h"

namespace wry::pipeline {

namespace {

using nlohmann::json;

constexpr int PICTURE_WIDTH = 560;
constexpr std::size_t PICTURES_PER_VIEW = 4;

std::string value_text(const json& value) {
  return value.is_string()         ? value.get<std::string>()
         : value.is_number_float() ? fmt::format("{:.6g}", value.get<double>())
                                   : value.dump();
}

void add_summary(const ShotSession& session, const ScenePlan& plan, HtmlPage& page) {
  page.section("Summary");
  std::vector<std::pair<std::string, std::string>> rows = {
      {"shot", session.shot.file},
      {"frames", fmt::format("{} to {} at {} per second", plan.sim.first_frame, plan.sim.last_frame, plan.sim.fps)},
      {"wry", fmt::format("{} (simulation {}, pictures {})", version(), simulation_build(), render_build())},
      {"inputs", plan.simulation_key}};
  if (const Result<std::string> text = read_whole_file(session.out / "summary.json"); text) {
    const json summary = json::parse(*text, nullptr, false);
    for (const char* key : {"isa", "solver"}) {
      if (summary.is_object() && summary.contains(key))
        rows.emplace_back(key, value_text(summary[key]));
    }
    if (summary.is_object() && summary.contains("expectations") && summary["expectations"].is_object()) {
      for (const auto& [name, verdict] : summary["expectations"].items())
        rows.emplace_back("expected: " + name, value_text(verdict));
    }
    if (summary.is_object() && summary.contains("wall_seconds") && summary["wall_seconds"].is_number())
      rows.emplace_back("time of the last run", human_duration(summary["wall_seconds"].get<double>()));
    if (summary.is_object() && summary.contains("this_run") && summary["this_run"].is_object()) {
      for (const auto& [key, value] : summary["this_run"].items()) {
        if (!value.is_object()) {
          rows.emplace_back(key, value_text(value));
          continue;
        }
        for (const auto& [part, of_part] : value.items())
          rows.emplace_back(fmt::format("{} {}", key, part), value_text(of_part));
      }
    }
  }
  page.facts(rows);
  for (const std::string& warning : plan.warnings)
    page.warning("warning: " + warning);
}

/// A few frames of each view, first and last among them.
Status add_pictures(const ShotSession& session, HtmlPage& page) {
  bool begun = false;
  for (const shots::Located<shots::View>& view : session.shot.render.views) {
    const std::size_t count = session.frames.size(), shown = std::min(count, PICTURES_PER_VIEW);
    for (std::size_t i = 0; i < shown; ++i) {
      const int frame = session.frames[shown > 1 ? i * (count - 1) / (shown - 1) : count - 1];
      const Result<render::PngContents> read =
          render::read_png(picture_path(session.out, *session.shot.shot.name, view->name, frame));
      if (!read)
        continue;
      if (!begun)
        page.section("Pictures");
      begun = true;
      const int width = std::min(PICTURE_WIDTH, read->image.width);
      const Result<std::vector<std::uint8_t>> png = render::encode_png(
          render::shrunk(read->image, width, std::max(1, width * read->image.height / read->image.width)), {},
          {render::PngAlpha::drop, 6});
      if (!png)
        return png.error();
      page.picture(*png, fmt::format("{}, frame {}", view->name, frame));
    }
  }
  return {};
}

void add_plan(const ScenePlan& plan, HtmlPage& page) {
  page.section("Plan");
  std::vector<std::pair<std::string, std::string>> bodies;
  for (const BodyReport& body : plan.bodies) {
    bodies.emplace_back(body.name,
                        fmt::format("{}: {} tets, {} dofs, {}; dihedral angles {:.1f} to {:.1f} degrees", body.source,
                                    body.tets, body.dofs, body.model, body.min_dihedral_deg, body.max_dihedral_deg));
    for (const std::string& note : body.notes)
      bodies.emplace_back("", note);
  }
  page.facts(bodies);
  std::vector<std::pair<std::string, std::string>> lines;
  for (const PlanLine& line : plan.runs)
    lines.emplace_back(line.what, line.why);
  page.section("Runs");
  page.facts(lines);
  lines.clear();
  for (const PlanLine& line : plan.left_out)
    lines.emplace_back(line.what, line.why);
  page.section("Left out");
  page.facts(lines);
  const double frame_count = plan.sim.last_frame - plan.sim.first_frame + 1;
  page.section("Predicted cost");
  page.facts({{"memory", human_bytes(double(plan.cost.memory_bytes))},
              {"disk", human_bytes(double(plan.cost.disk_bytes(frame_count)))},
              {"time", human_duration(plan.cost.seconds())}});
}

} // namespace

Status write_run_report(const ShotSession& session, const ScenePlan& plan) {
  std::string title = plan.name;
  if (session.shot.sweep_case)
    title += ", " + **session.shot.sweep_case;
  HtmlPage page(title);
  add_summary(session, plan, page);
  if (Status status = add_pictures(session, page); !status)
    return status;
  const std::vector<Plot> plots = run_plots(session.out);
  if (!plots.empty())
    page.section("Plots");
  for (const Plot& plot : plots)
    page.plot(plot);
  add_plan(plan, page);
  return write_file_atomically(session.out / "report.html", page.finish());
}

} // namespace wry::pipeline
