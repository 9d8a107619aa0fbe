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

std::vector<Field> motion_fields() {
  Section key;
  key.doc = "Where it is at a time, relative to where it rests; what is left out is as in the key before, or zero.";
  key.fields = {
      number("time", "s", between(-1e9, 1e9), "The time of the key; times ascend.").called("time").required(),
      numbers("translate", 3, "m", place(), "How far it has moved.").default_is("as in the key before"),
      plain("axis", Kind::direction,
            "The axis of the turn. Between keys of one axis the angle is interpolated, so it may turn many times; "
            "between others it goes the shortest way.")
          .default_is("as in the key before, or up"),
      number("degrees", "degrees", between(-1e9, 1e9), "How far it has turned about the pivot.")
          .called("angle")
          .default_is("as in the key before"),
  };
  return {
      nested("keys", Kind::table_list, key, "How it moves as a whole: a list of keys."),
      numbers("pivot", 3, "m", place(), "The point about which it turns.").standard(number_list({0, 0, 0})),
      choice("ease",
             {{"linear", "at constant speed from key to key", ""}, {"smooth", "each key is reached at rest", ""}},
             "How it goes from key to key.")
          .standard("linear"),
  };
}

namespace {

std::vector<Field> collider_shapes() {
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
  return {
      nested("plane", Kind::table, plane, plane.doc),
      variant(
          "box",
          {numbers("size", 3, "m", positive(1e9), "Lengths along x, y, z.").called("lengths").required(),
           word_list("open",
                     {{"-x", "", ""}, {"+x", "", ""}, {"-y", "", ""}, {"+y", "", ""}, {"-z", "", ""}, {"+z", "", ""}},
                     "Sides that are left out: a container.")
               .default_is("none: it is solid"),
           number("wall", "m", positive(1e9), "Thickness of the walls of a container, inside size.")
               .called("thickness")
               .default_is("none; a container needs it")},
          "A box around the origin, placed by rotate and translate."),
      variant("sphere", {number("radius", "m", positive(1e9), "Radius.").called("radius").required()},
              "A ball around the origin."),
      variant("cylinder",
              {number("radius", "m", positive(1e9), "Radius.").called("radius").required(),
               number("height", "m", positive(1e9), "Length along y.").called("height").required()},
              "A solid cylinder along y, its middle at the origin."),
      plain("mesh", Kind::path, "An artist mesh: solid when it is closed, else a sheet with two sides."),
  };
}

} // namespace

Section collider_section() {
  Section section;
  section.doc = "An obstacle that bodies rest on.";
  section.fields = {
      plain("name", Kind::name, "Names it in keys and messages.").default_is("collider1, collider2, ...")};
  const std::vector<Field> mesh_fields = {
      plain("node", Kind::text, "Of a mesh: only what hangs from the node of this name.").default_is("all of the file"),
      number("thickness", "m", at_least_zero(1e9), "Of an open mesh; grid methods feel at least a cell.")
          .called("thickness")
          .standard(0.0),
      plain("sequence", Kind::path,
            "The mesh over time: a PC2 point cache of it, or numbered meshes of the same topology "
            "(\"wave.####.obj\"). Frame f of the shot is frame f of the sequence; straight between frames.")
          .default_is("none: it does not deform"),
  };
  const std::vector<Field> behaviour = {
      number("friction", "", at_least_zero(1e6), "Coulomb's coefficient.").called("coefficient").standard(0.5),
      choice("contact",
             {{"separate", "matter may leave it, and slides with friction", ""},
              {"slip", "matter slides with friction, but does not leave", ""},
              {"sticky", "matter that touches it stays", ""}},
             "What touching matter may do; solids (FEM) know separate only.")
          .standard("separate"),
      choice("motion", {{"keys", "along keys", ""}, {"file", "the animation of its node in the mesh file", ""}},
             "Where its motion comes from.")
          .standard("keys"),
  };
  for (const std::vector<Field>& part :
       {collider_shapes(), mesh_fields, placement_fields(), behaviour, motion_fields()})
    section.fields.insert(section.fields.end(), part.begin(), part.end());
  section.fields.push_back(reference("look", "look", "The name of a [look.X], or a built-in look.")
                               .default_is("a neutral look")
                               .affects(Effect::pictures));
  section.fields.push_back(
      boolean("show", "Whether it is drawn; planes are drawn as the ground.").standard(true).affects(Effect::pictures));
  section.one_of = {{{{"plane"}, {"box"}, {"sphere"}, {"cylinder"}, {"mesh"}}, true, "shape"},
                    {{{"size"}, {"scale"}}, false, "size"}};
  return section;
}

Section measure_section() {
  Section section;
  section.doc = "A named scalar per frame, a column of measure.csv.";
  section.effect = Effect::nothing;
  section.fields = {
      plain("name", Kind::name, "The column's name.").required(),
      choice(
          "kind",
          {{"height", "extent along up [m]", ""},
           {"extent", "extent along axis [m]", ""},
           {"lowest", "lowest position along up [m]", ""},
           {"centre", "centre of mass along axis [m]", ""},
           {"volume", "volume [m^3]", ""},
           {"speed", "greatest speed of a node [m/s]", ""},
           {"kinetic_energy", "kinetic energy [J]", ""},
           {"strain_energy", "energy of deformation, with curvature [J]", ""},
           {"run_out",
            "of particles: how far 98 % of them have spread beyond the half width of the start, over it; "
            "along axis, or from the middle all around",
            ""},
           {"front_position", "of particles: 98 % of them are behind it along axis [m]", ""},
           {"pile_height",
            "of particles: the highest above the foot of the start; with where: of those that are in it now, above the "
            "lowest of them [m]",
            ""},
           {"repose_angle", "of particles: slope of the pile's surface about its middle [degrees]", ""},
           {"fraction_outside", "of particles: the part of them that is not in where", ""},
           {"curvature_energy", "the part of curvature in it [J]", ""},
           {"bound_low", "least coordinate along axis [m]", ""},
           {"bound_high", "greatest coordinate along axis [m]", ""},
           {"tip_position", "along axis, of the nodes that rest furthest along the body's longest side [m]", ""},
           {"momentum", "along axis [kg m/s]", ""},
           {"angular_momentum", "about axis through about [kg m^2/s]", ""},
           {"reaction_force", "of holds and drives on the body, along axis [N]", ""},
           {"reaction_torque", "of holds and drives on the body, about axis through about [N m]", ""},
           {"element_twist_max", "largest angle between microrotations of an element's nodes [degrees]", ""},
           {"rotation_distance", "mean angle of microrotations to the rotation of the matter [degrees]", ""},
           {"curvature_error", "largest relative error of wryness against spherical averaging", ""},
           {"rotation_interpolation_error", "largest angle to the spherical average [degrees]", ""},
           {"curve_radius", "of the helix that a slender body forms in its middle half [m]", ""},
           {"curve_pitch", "of that helix [m]", ""},
           {"mean_alignment",
            "of particles with axes: mean square of the cosine between their fibres and axis, or their own velocity",
            ""},
           {"second_moment", "of particles with axes: greatest eigenvalue of the fibres' mean second moment", ""},
           {"largest_fragment", "of particles: the part of them in the largest piece, touching within a cell", ""},
           {"grains_inside", "of sub_particles: how many have their centre inside a collider as it is drawn", ""},
           {"grain_hover",
            "of sub_particles: gap between those at rest, with no other beneath them, and the colliders, of 99 % [m]",
            ""},
           {"crossings",
            "of solids: how many edges cut or touch triangles, of the body with itself and with other solids, exactly; "
            "with where: those that have such a node",
            ""}},
          "What is measured.")
          .required(),
      reference("body", "body", "The name of a body.").default_is("the only body"),
      choice("axis", {{"x", "", ""}, {"y", "", ""}, {"z", "", ""}}, "The axis of what is measured along or about one.")
          .default_is("none; extent, centre, bounds, tip, momenta and reactions need it"),
      numbers("about", 3, "m", place(), "The point that reaction_torque and angular_momentum refer to.")
          .default_is("the middle of the nodes they look at"),
      choice("at", {{"nodes", "", ""}, {"points", "of quadrature", ""}, {"centroid", "of elements", ""}},
             "Where rotation_distance is taken.")
          .standard("nodes"),
      choice("rule",
             {{"velocity", "what the solver carries", ""},
              {"rotation-vectors", "mean of rotation vectors", ""},
              {"quaternion-blend", "normalised mean of quaternions", ""}},
             "What rotation_interpolation_error compares.")
          .standard("velocity"),
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
      boolean("every_frame", "On every frame: from `frame` on where it is given, else from the first.").standard(false),
      number("min", "", any_number(), "The least value that is right.").default_is("none"),
      number("max", "", any_number(), "The greatest value that is right.").default_is("none"),
      reference("case", "sweep.case", "Only in wedges of this case.").default_is("every wedge"),
      reference("ratio_to", "sweep.case", "The value is first divided by that of this case, all else equal.")
          .default_is("the value itself"),
  };
  return section;
}

} // namespace wry::shots
