#include "shots/presets.h"

#include <array>

#include <fmt/format.h>

namespace wry::shots {
namespace {

/// A material to start from. The values are round figures from the ranges that handbooks and data sheets give for the
/// class of matter, softened nowhere: a shot scales youngs_modulus itself when it wants a floppy prop.
struct Preset {
  const char* name;
  const char* description;
  const char* model;
  double density;        ///< [kg/m^3]
  double youngs_modulus; ///< [Pa]
  double poisson_ratio;
  double length_scale; ///< [m]; 0: curvature costs nothing
};

constexpr std::array PRESETS{
    Preset{"rubber", "vulcanised natural rubber, about 40 Shore A: E 1-5 MPa, nearly incompressible", "neo-hookean",
           930, 1.5e6, 0.49, 0.0},
    Preset{"silicone", "soft casting silicone, about 10 Shore A: E 0.1-0.3 MPa", "neo-hookean", 1070, 2e5, 0.48, 0.0},
    Preset{"gel", "ballistic or food gelatine, 10 %: E 50-150 kPa, as heavy as water", "neo-hookean", 1030, 1e5, 0.48,
           0.0},
    Preset{"flesh", "soft tissue, muscle and fat together: E 10-60 kPa", "neo-hookean", 1050, 3e4, 0.47, 0.0},
    Preset{"foam", "flexible polyurethane foam: E 20-100 kPa, hardly thins; cells of about 1 mm resist curvature",
           "micropolar", 40, 5e4, 0.1, 1e-3},
    Preset{"felt", "pressed wool felt: E 0.5-2 MPa; fibres a few mm long resist curvature", "micropolar", 250, 1e6, 0.1,
           3e-3},
    Preset{"cork", "E 10-30 MPa, does not thin when stretched; cells of about 0.1 mm", "micropolar", 180, 1.5e7, 0.0,
           1e-4},
    Preset{"leather", "tanned hide: E 20-100 MPa; fibre bundles of about 1 mm resist curvature", "micropolar", 900, 4e7,
           0.3, 1e-3},
};

} // namespace

Table preset_values(const std::string& name) {
  Table table;
  for (const Preset& preset : PRESETS) {
    if (name != preset.name) {
      continue;
    }
    const Place place{std::make_shared<const std::string>("preset " + name), 0, 0, Origin::preset, 1};
    table.set("model", Value(std::string(preset.model), place));
    table.set("density", Value(preset.density, place));
    table.set("youngs_modulus", Value(preset.youngs_modulus, place));
    table.set("poisson_ratio", Value(preset.poisson_ratio, place));
    table.set("length_scale", Value(preset.length_scale, place));
  }
  return table;
}

std::vector<PresetInfo> list_presets() {
  std::vector<PresetInfo> list;
  for (const Preset& preset : PRESETS) {
    list.push_back(PresetInfo{
        preset.name, fmt::format("{} ({}, {:g} kg/m^3, E {:g} Pa, nu {:g}{})", preset.description, preset.model,
                                 preset.density, preset.youngs_modulus, preset.poisson_ratio,
                                 preset.length_scale > 0 ? fmt::format(", L_c {:g} m", preset.length_scale) : "")});
  }
  return list;
}

std::vector<std::string> list_built_in_looks() {
  return {"brick",  "card", "ceramic", "clay", "glass", "metal", "paint",
          "rubber", "sand", "skin",    "snow", "straw", "wood"};
}

} // namespace wry::shots
