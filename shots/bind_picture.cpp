#include "shots/bind.h"

namespace wry::shots {
namespace {

View view_of(const std::string& name) {
  if (name.compare(0, 5, "heat.") == 0) {
    return View{ViewKind::heat, name.substr(5), name};
  }
  return View{name == "clay" ? ViewKind::clay : name == "wire" ? ViewKind::wire : ViewKind::beauty, {}, name};
}

Camera bind_camera(const Reader& reader) {
  Camera camera;
  camera.source = reader.source();
  camera.position = reader.optional_vector("position");
  camera.target = reader.optional_vector("target");
  camera.azimuth_deg = reader.number("azimuth_deg");
  camera.elevation_deg = reader.number("elevation_deg");
  camera.distance = reader.optional_number("distance");
  camera.lens = reader.number("lens");
  camera.margin = reader.number("margin");
  return camera;
}

} // namespace

RenderOptions bind_render(const Reader& reader) {
  RenderOptions render;
  render.source = reader.source();
  render.size = reader.integers<2>("size");
  render.samples = reader.integer("samples");
  for (const Located<std::string>& name : reader.texts("views")) {
    render.views.emplace_back(view_of(*name), name.source);
  }
  render.camera = bind_camera(reader.child("camera"));
  render.exposure = reader.number("exposure");
  const Reader ground = reader.child("ground");
  render.ground = Ground{ground.boolean("show"), ground.optional_number("height"), ground.vector("colour")};
  render.background = reader.vector("background");
  render.slate = reader.boolean("slate");
  render.shadows = reader.boolean("shadows");
  const Reader turntable = reader.child("turntable");
  render.turntable = Turntable{turntable.integer("frames"), turntable.optional_integer("frame")};
  for (const auto& [channel, range] : reader.named_children("heat")) {
    render.heat.push_back(
        HeatRange{range.source(), channel, range.optional_number("min"), range.optional_number("max")});
  }
  return render;
}

} // namespace wry::shots
