#include "shots/bind.h"

#include <array>
#include <utility>

namespace wry::shots {
namespace {

View view_of(const std::string& name) {
  if (name.compare(0, 5, "heat.") == 0) {
    return View{ViewKind::heat, name.substr(5), name};
  }
  constexpr std::array<std::pair<const char*, ViewKind>, 6> KINDS = {{{"beauty", ViewKind::beauty},
                                                                      {"clay", ViewKind::clay},
                                                                      {"wire", ViewKind::wire},
                                                                      {"directors", ViewKind::directors},
                                                                      {"fibres", ViewKind::fibres},
                                                                      {"contacts", ViewKind::contacts}}};
  for (const auto& [word, kind] : KINDS) {
    if (name == word) {
      return View{kind, {}, name};
    }
  }
  return View{ViewKind::beauty, {}, name};
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
  camera.look_at = reader.optional_text("look_at");
  camera.orbit_turns = reader.number("orbit_turns");
  for (const Reader& key : reader.children("keys")) {
    camera.keys.push_back(CameraKey{key.source(), key.integer("frame"), key.vector("position"),
                                    key.optional_vector("target"), key.optional_number("lens")});
  }
  camera.file = reader.optional_text("file");
  camera.node = reader.optional_text("node");
  return camera;
}

Lights bind_lights(const Reader& reader) {
  Lights lights;
  lights.source = reader.source();
  lights.rig = reader.choice<LightRig>(
      "rig", {{"studio", LightRig::studio}, {"day", LightRig::day}, {"image", LightRig::image}});
  lights.image = reader.optional_text("image");
  lights.turn_deg = reader.number("turn_deg");
  lights.stops = reader.number("stops");
  lights.turn_with = reader.optional_text("turn_with");
  lights.show_image = reader.boolean("show_image");
  return lights;
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
  render.ground = Ground{ground.boolean("show"), ground.optional_number("height"), ground.vector("colour"),
                         ground.boolean("catch_shadow")};
  render.background = reader.vector("background");
  render.slate = reader.boolean("slate");
  render.shadows = reader.boolean("shadows");
  render.lights = bind_lights(reader.child("lights"));
  render.motion_blur = reader.number("motion_blur");
  if (reader.has("depth_of_field")) {
    const Reader lens = reader.child("depth_of_field");
    render.depth_of_field = DepthOfField{lens.source(), lens.number("f_stop"), lens.optional_number("focus")};
  }
  render.filmic = reader.choice<bool>("tone", {{"filmic", true}, {"plain", false}});
  render.bits = reader.choice<std::int64_t>("bits", {{"8", 8}, {"16", 16}});
  render.alpha = reader.boolean("alpha");
  render.exr = reader.texts("exr");
  render.contact_sheet = reader.boolean("contact_sheet");
  const Reader turntable = reader.child("turntable");
  render.turntable =
      Turntable{turntable.integer("frames"), turntable.optional_integer("frame"), turntable.boolean("moving")};
  for (const auto& [channel, range] : reader.named_children("heat")) {
    render.heat.push_back(
        HeatRange{range.source(), channel, range.optional_number("min"), range.optional_number("max")});
  }
  return render;
}

} // namespace wry::shots
