#include "shots/shot.h"

#include <algorithm>

namespace wry::shots {
namespace {

template <class Items> auto* find_named(const Items& items, const std::string& name) {
  const auto found = std::find_if(items.begin(), items.end(), [&](const auto& item) { return *item.name == name; });
  return found == items.end() ? nullptr : &*found;
}

} // namespace

bool needs_axis(MeasureKind kind) {
  switch (kind) {
  case MeasureKind::extent:
  case MeasureKind::centre:
  case MeasureKind::front_position:
  case MeasureKind::bound_low:
  case MeasureKind::bound_high:
  case MeasureKind::tip_position:
  case MeasureKind::momentum:
  case MeasureKind::angular_momentum:
  case MeasureKind::reaction_force:
  case MeasureKind::reaction_torque:
    return true;
  default:
    return false;
  }
}

bool is_micropolar(MaterialModel model) {
  return model == MaterialModel::micropolar || model == MaterialModel::micropolar_det ||
         model == MaterialModel::micropolar_neo_hookean || model == MaterialModel::plate;
}

bool Material::has_rest_curvature() const {
  for (const auto& row : rest_curvature) {
    for (const auto& entry : row) {
      if (entry && !(entry->value.constant && *entry->value.constant == 0.0)) {
        return true;
      }
    }
  }
  return false;
}

const Material* Shot::find_material(const std::string& name) const {
  return find_named(materials, name);
}
const Look* Shot::find_look(const std::string& name) const {
  return find_named(looks, name);
}
const Body* Shot::find_body(const std::string& name) const {
  return find_named(bodies, name);
}

std::string Source::text() const {
  if (line > 0) {
    return fmt::format("{}:{}:{}: {}", file, line, column, key);
  }
  return file.empty() ? key : fmt::format("{}: {}", file, key);
}

bool Shot::is_particles(const Body& body) const {
  const Material* material = find_material(*body.material);
  return material != nullptr && *material->model == MaterialModel::mpm;
}

} // namespace wry::shots
