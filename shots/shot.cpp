#include "shots/shot.h"

#include <algorithm>

namespace wry::shots {
namespace {

template <class Items> auto* find_named(const Items& items, const std::string& name) {
  const auto found = std::find_if(items.begin(), items.end(), [&](const auto& item) { return *item.name == name; });
  return found == items.end() ? nullptr : &*found;
}

} // namespace

bool is_micropolar(MaterialModel model) {
  return model == MaterialModel::micropolar || model == MaterialModel::micropolar_det ||
         model == MaterialModel::micropolar_neo_hookean;
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

} // namespace wry::shots
