#include <cstdio>

#include <fmt/format.h>

#include "pipeline/cli/verb.h"
#include "pipeline/measure/measure.h"
#include "pipeline/plan/build_id.h"
#include "render/look.h"
#include "shots/reference.h"
#include "sim/base/isa.h"

namespace wry::pipeline {

namespace {

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words)
    text += (text.empty() ? "" : ", ") + word;
  return text;
}

} // namespace

Status list_verb(const Invocation&) {
  std::string text =
      fmt::format("wry {} (simulation {}, pictures {})\n", version(), simulation_build(), render_build());
  text += fmt::format("instruction sets   up to {} on this machine\n", isa_name(native_isa()));
  text += "material models    " + joined(shots::list_choices("material.*.model")) + "\n";
  text += "linear solvers     " + joined(shots::list_choices("fem.linear_solver")) + "\n";
  text += "views              beauty, clay, wire, heat.<channel>, directors, fibres, contacts\n";
  std::vector<std::string> looks;
  for (const auto& [name, look] : render::built_in_looks())
    looks.push_back(name);
  text += "looks              " + joined(looks) + "\n";
  text += "presets\n";
  for (const shots::PresetInfo& preset : shots::list_presets())
    text += fmt::format("  {:<16} {}\n", preset.name, preset.description);
  text += "measures\n";
  for (const MeasureFunction& measure : measure_functions())
    text += fmt::format("  {:<16} {} [{}]\n", measure.name, measure.doc, measure.unit);
  std::fputs(text.c_str(), stdout);
  return {};
}

} // namespace wry::pipeline
