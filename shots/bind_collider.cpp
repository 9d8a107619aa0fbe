#include "shots/bind.h"

namespace wry::shots {
namespace {

PlaneShape bind_plane(const Reader& shape) {
  PlaneShape plane{shape.vector("point"), shape.vector("normal")};
  const auto height = shape.optional_number("height");
  if (!shape.has("point") && height) {
    const double length = plane.normal->norm();
    plane.point = Located<Vec3>(length > 0.0 ? Vec3(plane.normal.value * (**height / length)) : Vec3(Vec3::Zero()),
                                height->source);
  }
  return plane;
}

ColliderShape bind_collider_shape(const Reader& reader, const std::string& directory) {
  if (reader.has("plane")) {
    return bind_plane(reader.child("plane"));
  }
  if (reader.has("box")) {
    const Reader box = reader.child("box");
    OpenBoxShape shape{box.vector("size"), box.texts("open"), std::nullopt};
    if (box.has("wall")) {
      shape.wall = box.number("wall");
    }
    return shape;
  }
  if (reader.has("sphere")) {
    return SphereShape{reader.child("sphere").number("radius")};
  }
  if (reader.has("cylinder")) {
    const Reader cylinder = reader.child("cylinder");
    return CylinderShape{cylinder.number("radius"), cylinder.number("height")};
  }
  ColliderMeshShape mesh{bind_path(reader, "mesh", directory), reader.optional_text("node"), reader.number("thickness"),
                         std::nullopt};
  if (reader.has("sequence"))
    mesh.sequence = bind_path(reader, "sequence", directory);
  return mesh;
}

} // namespace

Motion bind_motion(const Reader& reader, Axis up) {
  Motion motion;
  MotionKey before;
  before.axis = Vec3::Unit(static_cast<int>(up));
  for (const Reader& key : reader.children("keys")) {
    before.source = key.source();
    before.time = key.number("time");
    if (const auto translate = key.optional_vector("translate")) {
      before.translate = **translate;
    }
    if (const auto axis = key.optional_vector("axis")) {
      before.axis = **axis;
    }
    if (key.has("degrees")) {
      before.degrees = *key.number("degrees");
    }
    motion.keys.push_back(before);
  }
  motion.pivot = reader.vector("pivot");
  motion.ease = reader.choice<Ease>("ease", {{"linear", Ease::linear}, {"smooth", Ease::smooth}});
  return motion;
}

Collider bind_collider(const Reader& reader, const std::string& directory, Axis up) {
  Collider collider;
  collider.source = reader.source();
  collider.name = reader.text("name");
  collider.shape = bind_collider_shape(reader, directory);
  bind_placement(reader, collider);
  collider.friction = reader.number("friction");
  collider.contact = reader.choice<ColliderContact>(
      "contact",
      {{"separate", ColliderContact::separate}, {"slip", ColliderContact::slip}, {"sticky", ColliderContact::sticky}});
  collider.motion = bind_motion(reader, up);
  collider.motion.from = reader.choice<MotionFrom>("motion", {{"keys", MotionFrom::keys}, {"file", MotionFrom::file}});
  collider.look = reader.optional_text("look");
  collider.show = reader.boolean("show");
  return collider;
}

} // namespace wry::shots
