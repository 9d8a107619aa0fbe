#include <filesystem>

#include "shots/check.h"

namespace wry::shots {
namespace {

std::string safe_name_of(const std::string& file) {
  std::string name = std::filesystem::path(file).stem().string().substr(0, 64);
  for (char& c : name) {
    if (!is_safe_name(std::string{'a', c}, Dots::refused)) {
      c = '_';
    }
  }
  return is_safe_name(name, Dots::allowed) ? name : "shot";
}

void set_if_absent(Table& table, const std::string& key, Value value) {
  if (!table.find(key)) {
    table.set(key, std::move(value));
  }
}

Array* items(Table& root, const std::string& key) {
  Value* value = root.find(key);
  return value ? value->get<Array>() : nullptr;
}

std::string up_axis(const Table& shot) {
  const Value* up = shot.find("up");
  const auto* axis = up ? up->get<std::string>() : nullptr;
  return axis && (*axis == "x" || *axis == "z") ? *axis : "y";
}

/// Of a shot with one body it need not be said which.
void fill_only_body(Table& root, const std::string& section) {
  const Array* bodies = items(root, "body");
  const Table* only = bodies && bodies->size() == 1 ? bodies->front().get<Table>() : nullptr;
  const Value* name = only ? only->find("name") : nullptr;
  Array* list = name && name->get<std::string>() ? items(root, section) : nullptr;
  if (!list) {
    return;
  }
  for (Value& item : *list) {
    if (Table* table = item.get<Table>()) {
      set_if_absent(*table, "body", Value(*name->get<std::string>()));
    }
  }
}

void fill_planes(Table& root, const std::string& up) {
  Array* colliders = items(root, "collider");
  if (!colliders) {
    return;
  }
  for (Value& collider : *colliders) {
    Table* table = collider.get<Table>();
    Value* plane = table ? table->find("plane") : nullptr;
    if (Table* shape = plane ? plane->get<Table>() : nullptr) {
      set_if_absent(*shape, "normal", Value(up));
      if (!shape->find("point")) {
        set_if_absent(*shape, "height", Value(0.0));
      }
    }
  }
}

} // namespace

void name_unnamed(Table& root) {
  for (const char* section : {"fixed", "drive", "load", "collider"}) {
    Array* list = items(root, section);
    for (std::size_t i = 0; list && i < list->size(); ++i) {
      if (Table* table = (*list)[i].get<Table>()) {
        set_if_absent(*table, "name", Value(fmt::format("{}{}", section, i + 1)));
      }
    }
  }
}

void fill_derived_defaults(Table& root, const std::string& file) {
  set_if_absent(root, "shot", Value(Table()));
  std::string up = "y";
  if (Table* shot = root.find("shot")->get<Table>()) {
    up = up_axis(*shot);
    set_if_absent(*shot, "name", Value(safe_name_of(file)));
    const double g = 9.81;
    set_if_absent(*shot, "gravity", number_list({up == "x" ? -g : 0, up == "y" ? -g : 0, up == "z" ? -g : 0}));
  }
  fill_planes(root, up);
  fill_only_body(root, "fixed");
  fill_only_body(root, "drive");
  fill_only_body(root, "load");
  fill_only_body(root, "measure");
}

void fill_rod_heights(Table& checked) {
  Array* bodies = items(checked, "body");
  if (!bodies) {
    return;
  }
  for (Value& body : *bodies) {
    Value* rod = body.get<Table>()->find("rod");
    if (Table* shape = rod ? rod->get<Table>() : nullptr) {
      if (const Value* width = shape->find("width")) {
        set_if_absent(*shape, "height", Value(width->number()));
      }
    }
  }
}

} // namespace wry::shots
