#include "shots/bind.h"

namespace wry::shots {

std::array<std::optional<Located<Expression>>, 3> bind_components(const Reader& reader) {
  std::array<std::optional<Located<Expression>>, 3> components;
  constexpr std::array AXES{"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i) {
    const Located<Expression> entry = reader.expression(AXES[i]);
    if (reader.has(AXES[i])) {
      components[i] = entry;
    }
  }
  return components;
}

Drive bind_drive(const Reader& reader, Axis up) {
  Drive drive;
  drive.source = reader.source();
  drive.name = reader.text("name");
  drive.body = reader.text("body");
  drive.where = bind_region(reader.child("where"));
  const Source words = reader.text("drive").source;
  drive.positions = drive.microrotations = Located<bool>(false, words);
  for (const Located<std::string>& word : reader.texts("drive")) {
    (*word == "positions" ? drive.positions : drive.microrotations).value = true;
  }
  drive.motion = bind_motion(reader, up);
  drive.collider = reader.optional_text("collider");
  drive.method = reader.choice<DriveMethod>(
      "method", {{"exact", DriveMethod::exact}, {"penalty", DriveMethod::penalty}, {"soft", DriveMethod::soft}});
  drive.stiffness = reader.number("stiffness");
  drive.turning_stiffness = reader.number("turning_stiffness");
  drive.until = reader.optional_number("until");
  return drive;
}

Load bind_load(const Reader& reader) {
  Load load;
  load.source = reader.source();
  load.name = reader.text("name");
  load.body = reader.text("body");
  if (reader.has("where")) {
    load.where = bind_region(reader.child("where"));
  }
  load.per =
      reader.choice<LoadPer>("per", {{"volume", LoadPer::volume}, {"area", LoadPer::area}, {"whole", LoadPer::whole}});
  load.force = bind_components(reader.child("force"));
  load.torque = bind_components(reader.child("torque"));
  return load;
}

} // namespace wry::shots
