#include "shots/schema.h"

namespace wry::shots {
namespace {

Interval place() {
  return between(-1e9, 1e9);
}

Field variant(std::string key, std::vector<Field> fields, std::string doc) {
  Section section;
  section.doc = doc;
  section.fields = std::move(fields);
  return nested(std::move(key), Kind::table, std::move(section), std::move(doc));
}

} // namespace

Section region_section() {
  Section section;
  section.doc = "Picks nodes by where they rest in the shot's world, after the body was placed.";
  section.fields = {
      variant("box",
              {numbers("min", 3, "m", place(), "The least corner.").required(),
               numbers("max", 3, "m", place(), "The greatest corner.").required()},
              "Nodes in a box."),
      variant("sphere",
              {numbers("centre", 3, "m", place(), "The middle.").required(),
               number("radius", "m", positive(1e9), "Radius.").called("radius").required()},
              "Nodes in a ball."),
      variant("cylinder",
              {numbers("from", 3, "m", place(), "One end of the axis.").required(),
               numbers("to", 3, "m", place(), "The other end.").required(),
               number("radius", "m", positive(1e9), "Radius.").called("radius").required()},
              "Nodes in a cylinder."),
      plain("expression", Kind::expression, "Nodes where a formula of X, Y, Z, u, v is not 0: \"Y < 0.02\"."),
      plain("attribute", Kind::text, "Nodes where this attribute of the mesh is above 0.5."),
  };
  section.one_of = {{{{"box"}, {"sphere"}, {"cylinder"}, {"expression"}, {"attribute"}}, true, "region"}};
  return section;
}

Section fixed_section() {
  Section section;
  section.doc = "Nodes that are held where they rest.";
  section.fields = {
      plain("name", Kind::name, "Names it in keys and messages.").default_is("fixed1, fixed2, ..."),
      reference("body", "body", "The name of a body.").default_is("the only body"),
      nested("where", Kind::table, region_section(), "Which nodes.").required(),
      number("until", "s", at_least_zero(1e9), "They are released after this time.").called("time").default_is("never"),
      word_list("hold", {{"positions", "", ""}, {"microrotations", "of micropolar bodies", ""}}, "What is held.")
          .standard(text_list({"positions", "microrotations"})),
  };
  return section;
}

Section collider_section() {
  Section plane;
  plane.doc = "A half-space that bodies stay out of.";
  plane.fields = {
      numbers("point", 3, "m", place(), "A point on the plane.").default_is("from height"),
      number("height", "m", place(), "Where the plane stands along its normal, in place of point.")
          .called("height")
          .default_is("0"),
      plain("normal", Kind::direction, "Towards the free side: \"y\" or [x, y, z].").default_is("up"),
  };
  plane.one_of = {{{{"point"}, {"height"}}, false, "place"}};
  Section section;
  section.doc = "An obstacle that bodies rest on.";
  section.fields = {
      plain("name", Kind::name, "Names it in keys and messages.").default_is("collider1, collider2, ..."),
      nested("plane", Kind::table, plane, plane.doc),
      number("friction", "", at_least_zero(1e6), "Coulomb's coefficient.").called("coefficient").standard(0.5),
  };
  section.one_of = {{{{"plane"}}, true, "shape"}};
  section.later = {{"box", "box colliders"},     {"sphere", "sphere colliders"},
                   {"mesh", "mesh colliders"},   {"motion", "moving colliders"},
                   {"keys", "moving colliders"}, {"contact", "sticky and separating colliders"}};
  return section;
}

Section measure_section() {
  Section section;
  section.doc = "A named scalar per frame, a column of measure.csv.";
  section.effect = Effect::nothing;
  section.fields = {
      plain("name", Kind::name, "The column's name.").required(),
      choice("kind",
             {{"height", "extent along up [m]", ""},
              {"extent", "extent along axis [m]", ""},
              {"lowest", "lowest position along up [m]", ""},
              {"centre", "centre of mass along axis [m]", ""},
              {"volume", "volume [m^3]", ""},
              {"speed", "greatest speed of a node [m/s]", ""},
              {"kinetic_energy", "kinetic energy [J]", ""},
              {"strain_energy", "energy of deformation, with curvature [J]", ""}},
             "What is measured.")
          .required(),
      reference("body", "body", "The name of a body.").default_is("the only body"),
      choice("axis", {{"x", "", ""}, {"y", "", ""}, {"z", "", ""}}, "The axis of extent and centre.")
          .default_is("none; extent and centre need it"),
      nested("where", Kind::table, region_section(), "Only these nodes.").default_is("all nodes"),
      boolean("relative", "Divided by its value in the first frame.").standard(false),
  };
  return section;
}

Section expect_section() {
  Section section;
  section.doc = "A range that a measure has to keep; else the run ends with exit code 1.";
  section.effect = Effect::nothing;
  section.fields = {
      reference("measure", "measure", "The name of a [[measure]].").required(),
      integer("frame", between(0, 1e7), "The frame.").or_word("last", "the last frame"),
      number("min", "", any_number(), "The least value that is right.").default_is("none"),
      number("max", "", any_number(), "The greatest value that is right.").default_is("none"),
      reference("case", "sweep.case", "Only in wedges of this case.").default_is("every wedge"),
      reference("ratio_to", "sweep.case", "The value is first divided by that of this case, all else equal.")
          .default_is("the value itself"),
  };
  return section;
}

} // namespace wry::shots
