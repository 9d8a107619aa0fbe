#include "shots/schema.h"

namespace wry::shots {

Section drive_section() {
  Section section;
  section.doc =
      "Nodes that are moved as a whole along keys, or with a collider, from where they rest; of particles, a part of "
      "space that moves with the matter in it.";
  section.fields = {
      plain("name", Kind::name, "Names it in keys and messages.").default_is("drive1, drive2, ..."),
      reference("body", "body", "The name of a body.").default_is("the only body"),
      nested("where", Kind::table, region_section(), "Which nodes.").required(),
      word_list("drive", {{"positions", "", ""}, {"microrotations", "of micropolar bodies", ""}}, "What is given.")
          .standard(text_list({"positions", "microrotations"})),
  };
  for (Field& field : motion_fields()) {
    section.fields.push_back(std::move(field));
  }
  const std::vector<Field> rest = {
      reference("collider", "collider", "The collider that they are attached to, in place of keys.").default_is("none"),
      choice("method",
             {{"exact", "they are where the motion says; steps are cut where it turns fast", ""},
              {"penalty", "by springs ten thousand times stiffer than the matter around a node", ""},
              {"soft", "by springs of the given stiffness", ""}},
             "How firmly they follow.")
          .standard("exact"),
      number("stiffness", "N/m", at_least_zero(), "Of all soft springs together, shared out by mass.")
          .called("stiffness")
          .standard(0.0),
      number("turning_stiffness", "N m", at_least_zero(), "The same for microrotations: torque per sine of the angle.")
          .called("stiffness")
          .standard(0.0),
      number("until", "s", at_least_zero(1e9), "They are released after this time.").called("time").default_is("never"),
  };
  section.fields.insert(section.fields.end(), rest.begin(), rest.end());
  section.one_of = {{{{"keys"}, {"collider"}}, false, "motion"}};
  return section;
}

namespace {

Field components(const char* key, const char* unit, std::string doc) {
  Section section;
  section.doc = doc;
  for (const char* axis : {"x", "y", "z"}) {
    Field entry = plain(axis, Kind::expression, "A number or a formula of t.").default_is("0");
    entry.unit = unit;
    section.fields.push_back(entry);
  }
  return nested(key, Kind::table, section, std::move(doc));
}

} // namespace

Section load_section() {
  Section section;
  section.doc = "Forces and torques that act on nodes, along the world's axes.";
  section.fields = {
      plain("name", Kind::name, "Names it in keys and messages.").default_is("load1, load2, ..."),
      reference("body", "body", "The name of a body.").default_is("the only body"),
      nested("where", Kind::table, region_section(), "Which nodes.").default_is("all nodes"),
      choice("per",
             {{"volume", "force per m^3, torque per m^3: a body torque", ""},
              {"area", "per m^2 of the surface whose three corners are all picked: a surface couple", ""},
              {"whole", "shared out by volume", ""}},
             "What force and torque refer to.")
          .standard("volume"),
      components("force", "N", "Along x, y and z."),
      components("torque", "N m", "About x, y and z, on the microrotations of micropolar bodies."),
  };
  return section;
}

Field rest_rotation_field() {
  return components("rest_rotation", "degrees",
                    "Rotation vector of the directors at rest, formulas of X, Y, Z, u, v and mesh attributes: the axes "
                    "that curvature stiffness and rest curvature refer to.");
}

} // namespace wry::shots
