#include <fmt/ranges.h>

#include "shots/reference.h"
#include "shots/schema.h"

namespace wry::shots {
namespace {

Interval length() {
  return positive(1e9);
}

Field shape(std::string key, std::vector<Field> fields, std::string doc) {
  Section section;
  section.doc = doc;
  section.fields = std::move(fields);
  return nested(std::move(key), Kind::table, std::move(section), std::move(doc));
}

std::vector<Field> shapes() {
  return {
      plain("mesh", Kind::path, "An artist mesh (obj, ply, stl, gltf, glb, fbx, ...), or a tet mesh of Gmsh (.msh)."),
      shape("box", {numbers("size", 3, "m", length(), "Lengths along x, y, z.").called("lengths").required()},
            "A box around the origin."),
      shape("sphere", {number("radius", "m", length(), "Radius.").called("radius").required()},
            "A ball around the origin."),
      shape("cylinder",
            {number("radius", "m", length(), "Radius.").called("radius").required(),
             number("height", "m", length(), "Length along y.").called("height").required()},
            "A solid cylinder along y, its middle at the origin."),
      shape("rod",
            {number("length", "m", length(), "Length along x; the coordinate u runs along it.")
                 .called("length")
                 .required(),
             number("width", "m", length(), "Width along z.").called("width").required(),
             number("height", "m", length(), "Height along y.").called("height").default_is("the width")},
            "A bar along x, its middle at the origin."),
      shape("sheet",
            {number("width", "m", length(), "Length along x, the coordinate u.").called("width").required(),
             number("depth", "m", length(), "Length along z, the coordinate v.").called("depth").required(),
             number("thickness", "m", length(), "Thickness along y.").called("thickness").required()},
            "A sheet in the x-z plane, its middle at the origin."),
      shape("torus",
            {number("radius", "m", length(), "Radius of the circle that the tube follows.").called("radius").required(),
             number("tube_radius", "m", length(), "Radius of the tube, less than radius.").called("radius").required()},
            "A ring around y, its middle at the origin."),
  };
}

Field size_field() {
  Section section;
  section.doc = "Scales the body evenly until one extent has this length.";
  section.fields = {
      number("height", "m", length(), "Extent along up.").called("height"),
      number("width", "m", length(), "Extent along x (y when up is x).").called("width"),
      number("depth", "m", length(), "Extent along the axis that is neither height nor width.").called("depth"),
      number("max", "m", length(), "The largest extent.").called("length"),
  };
  section.one_of = {{{{"height"}, {"width"}, {"depth"}, {"max"}}, true, "extent"}};
  return nested("size", Kind::table, section, section.doc);
}

} // namespace

std::vector<Field> placement_fields() {
  Section rotation;
  rotation.doc = "A rotation about an axis through the origin.";
  rotation.fields = {
      plain("axis", Kind::direction, "The axis: \"x\", \"-y\", ... or [x, y, z].").required(),
      number("degrees", "degrees", between(-1e6, 1e6), "The angle, counter-clockwise about the axis.")
          .called("angle")
          .required(),
  };
  return {
      size_field(),
      number("scale", "", length(), "Factor on the size, after units.").called("factor").standard(1.0),
      choice("units",
             {{"m", "metres", ""},
              {"dm", "decimetres", ""},
              {"cm", "centimetres", ""},
              {"mm", "millimetres", ""},
              {"in", "inches", ""},
              {"ft", "feet", ""}},
             "What a unit of the mesh file is; FBX files often come in cm.")
          .standard("m"),
      choice("up", {{"x", "", ""}, {"y", "", ""}, {"z", "", ""}},
             "The up axis of the mesh file; it is turned to the shot's.")
          .default_is("the shot's"),
      nested("rotate", Kind::table_list, rotation,
             "One rotation or a list of them, applied in order after size and scale."),
      numbers("translate", 3, "m", between(-1e9, 1e9), "Where it is moved to, last.").standard(number_list({0, 0, 0})),
  };
}

namespace {

std::vector<Field> discretisation() {
  Section shell;
  shell.doc = "Hollows the body: a wall of tets behind its surface.";
  shell.fields = {
      number("thickness", "m", length(), "Thickness of the wall.").called("thickness").required(),
      integer("layers", between(1, 64), "Layers of tets across the wall; one bends far too stiffly.").standard(2),
  };
  return {
      nested("shell", Kind::table, shell, shell.doc),
      number("resolution", "m", length(), "Target length of edges.").called("length"),
      integers("cells", 3, between(1, 100'000),
               "Cells along x, y, z of a box, rod, sheet or cylinder, in place of resolution."),
      choice("split",
             {{"symmetric", "diagonals alternate, so that no direction is favoured", ""},
              {"kuhn", "six tets per cell, all diagonals alike", ""}},
             "How the cells of a box, rod, sheet or cylinder are cut into tets.")
          .standard("symmetric"),
      choice("element",
             {{"auto", "tet4, and tri6 for plates", ""},
              {"tet4", "linear positions and microrotations", ""},
              {"tet10", "quadratic positions, linear microrotations; of micropolar", ""},
              {"tri3", "of plates: linear positions; stiff where the plate is thinner than its cells", ""},
              {"tri6", "of plates: quadratic positions", ""}},
             "The finite element.")
          .standard("auto"),
      choice("quadrature",
             {{"full", "as many points as the element needs", ""},
              {"one-point", "of tet4 and micropolar: leaves microrotations that cost nothing, to be seen", ""}},
             "Where the energy of an element is sampled.")
          .standard("full"),
  };
}

} // namespace

Section body_section() {
  Section section;
  section.doc = "A solid: its shape, where it stands, what it is made of.";
  section.fields = {plain("name", Kind::name, "Names it in keys, files and messages.").required()};
  for (std::vector<Field> part :
       {shapes(), placement_fields(),
        std::vector<Field>{numbers("velocity", 3, "m/s", between(-1e6, 1e6), "Velocity at the start.")
                               .standard(number_list({0, 0, 0})),
                           rest_rotation_field()},
        discretisation(), mpm_body_fields()}) {
    section.fields.insert(section.fields.end(), part.begin(), part.end());
  }
  section.fields.push_back(reference("material", "material", "The name of a [material.X].").required());
  section.fields.push_back(
      reference("look", "look",
                fmt::format("The name of a [look.X], or one of {}.", fmt::join(list_built_in_looks(), ", ")))
          .default_is("a neutral look")
          .affects(Effect::pictures));
  section.fields.push_back(
      choice("draw",
             {{"auto", "the shape, where there is one near enough to the elements", ""},
              {"shape", "the mesh, sphere or torus itself, carried by the elements", ""},
              {"elements", "the faces of the elements; wire, heat and the views with signs always show these", ""}},
             "What of the body is drawn.")
          .standard("auto")
          .affects(Effect::pictures));
  section.one_of = {
      {{{"mesh"}, {"box"}, {"sphere"}, {"cylinder"}, {"rod"}, {"sheet"}, {"torus"}, {"region"}}, true, "shape"},
      {{{"size"}, {"scale"}}, false, "size"},
      {{{"resolution"}, {"cells"}}, false, "resolution"},
  };
  return section;
}

} // namespace wry::shots
