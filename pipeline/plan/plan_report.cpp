#include "pipeline/plan/plan_report.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "pipeline/report/readable.h"

namespace wry::pipeline {

namespace {

std::string size_text(const Vec3& size) {
  return fmt::format("{:.3g} x {:.3g} x {:.3g} m", size[0], size[1], size[2]);
}

void append_body(std::string& text, const BodyReport& body) {
  text += fmt::format("\nbody {}: {}, {}\n", body.name, body.source, size_text(body.size));
  if (body.particles > 0) {
    text += fmt::format("  {} particles of {} bytes; {:.4g} m^3, {:.4g} kg\n", body.particles, body.bytes_per_particle,
                        body.volume, body.mass);
    text += fmt::format("  model: {}\n", body.model);
    for (const std::string& note : body.notes)
      text += "  note: " + note + "\n";
    return;
  }
  text += fmt::format("  {} tets, {} nodes, {} dofs, {} surface triangles; {:.4g} m^3, {:.4g} kg\n", body.tets,
                      body.nodes, body.dofs, body.surface_triangles, body.volume, body.mass);
  text += fmt::format("  quality: dihedral angles {:.1f} to {:.1f} degrees, edges {:.3g} m least, {:.3g} m mean\n",
                      body.min_dihedral_deg, body.max_dihedral_deg, body.min_edge, body.mean_edge);
  text += fmt::format("  model: {}\n", body.model);
  for (const std::string& note : body.notes)
    text += "  note: " + note + "\n";
}

/// "; saves 12 s, 3.1 MiB of memory": what is worth saying of it.
std::string saving_text(const std::optional<Saving>& saving) {
  if (!saving)
    return "";
  constexpr double SECOND = 0.5, BYTES = 100e3;
  std::vector<std::string> saved, spent;
  const auto say = [&](double value, double least, const std::string& amount) {
    if (std::abs(value) >= least)
      (value > 0.0 ? saved : spent).push_back(amount);
  };
  say(saving->seconds, SECOND, human_duration(std::abs(saving->seconds)));
  say(saving->memory_bytes, BYTES, human_bytes(std::abs(saving->memory_bytes)) + " of memory");
  say(saving->disk_bytes, BYTES, human_bytes(std::abs(saving->disk_bytes)) + " of disk");
  std::string text;
  if (!saved.empty())
    text += fmt::format("; saves {}", fmt::join(saved, ", "));
  if (!spent.empty())
    text += fmt::format("; it would save {}", fmt::join(spent, ", "));
  return text;
}

void append_lines(std::string& text, const char* title, const std::vector<PlanLine>& lines) {
  if (lines.empty())
    return;
  std::size_t width = 0;
  for (const PlanLine& line : lines)
    width = std::max(width, line.what.size());
  text += fmt::format("\n{}\n", title);
  for (const PlanLine& line : lines)
    text += fmt::format("  {:<{}}  {}{}\n", line.what, width, line.why, saving_text(line.saving));
}

nlohmann::json json_of(const BodyReport& body) {
  return {{"name", body.name},
          {"source", body.source},
          {"model", body.model},
          {"size_m", {body.size[0], body.size[1], body.size[2]}},
          {"particles", body.particles},
          {"bytes_per_particle", body.bytes_per_particle},
          {"tets", body.tets},
          {"nodes", body.nodes},
          {"dofs", body.dofs},
          {"surface_triangles", body.surface_triangles},
          {"volume_m3", body.volume},
          {"mass_kg", body.mass},
          {"min_dihedral_deg", body.min_dihedral_deg},
          {"max_dihedral_deg", body.max_dihedral_deg},
          {"min_edge_m", body.min_edge},
          {"mean_edge_m", body.mean_edge},
          {"notes", body.notes}};
}

nlohmann::json json_of(const std::vector<PlanLine>& lines) {
  nlohmann::json list = nlohmann::json::array();
  for (const PlanLine& line : lines) {
    nlohmann::json entry = {{"what", line.what}, {"why", line.why}};
    if (line.saving)
      entry["saves"] = {{"seconds", line.saving->seconds},
                        {"memory_bytes", line.saving->memory_bytes},
                        {"disk_bytes", line.saving->disk_bytes}};
    list.push_back(std::move(entry));
  }
  return list;
}

} // namespace

std::string plan_text(const ScenePlan& plan) {
  std::string text = fmt::format("{}: frames {}-{} at {} per second, {:.4g} s\n", plan.name, plan.sim.first_frame,
                                 plan.sim.last_frame, plan.sim.fps, plan.sim.time_of(plan.sim.last_frame));
  for (const BodyReport& body : plan.bodies)
    append_body(text, body);
  append_lines(text, "runs", plan.runs);
  append_lines(text, "left out", plan.left_out);
  const CostEstimate& cost = plan.cost;
  const double frame_count = plan.sim.last_frame - plan.sim.first_frame + 1;
  text += fmt::format("\ncost (predicted)\n  memory  {}\n  disk    {} ({} per frame, {} per checkpoint)\n  time    {} "
                      "({:.0f} steps of {:.3g} s)\n",
                      human_bytes(double(cost.memory_bytes)), human_bytes(double(cost.disk_bytes(frame_count))),
                      human_bytes(double(cost.bytes_per_frame)), human_bytes(double(cost.bytes_per_checkpoint)),
                      human_duration(cost.seconds()), cost.steps, cost.time_step);
  for (const std::string& warning : plan.warnings)
    text += "warning: " + warning + "\n";
  return text;
}

std::string plan_json(const ScenePlan& plan) {
  nlohmann::json bodies = nlohmann::json::array();
  for (const BodyReport& body : plan.bodies)
    bodies.push_back(json_of(body));
  nlohmann::json assets = nlohmann::json::array();
  for (const Asset& asset : plan.assets)
    assets.push_back({{"path", asset.path}, {"sha256", asset.sha256}});
  const double frame_count = plan.sim.last_frame - plan.sim.first_frame + 1;
  const nlohmann::json report = {{"name", plan.name},
                                 {"first_frame", plan.sim.first_frame},
                                 {"last_frame", plan.sim.last_frame},
                                 {"fps", plan.sim.fps},
                                 {"simulation_key", plan.simulation_key},
                                 {"bodies", bodies},
                                 {"assets", assets},
                                 {"runs", json_of(plan.runs)},
                                 {"left_out", json_of(plan.left_out)},
                                 {"warnings", plan.warnings},
                                 {"cost",
                                  {{"memory_bytes", plan.cost.memory_bytes},
                                   {"disk_bytes", plan.cost.disk_bytes(frame_count)},
                                   {"seconds", plan.cost.seconds()},
                                   {"steps", plan.cost.steps},
                                   {"time_step_s", plan.cost.time_step}}}};
  return report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

} // namespace wry::pipeline
