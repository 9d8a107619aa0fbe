#include "shots/schema.h"

namespace wry::shots {
namespace {

/// A table that is not there unless it is given.
Field optional_table(const char* key, std::vector<Field> fields, std::string doc, const char* absent,
                     std::vector<OneOf> one_of = {}) {
  Section section;
  section.doc = doc;
  section.fields = std::move(fields);
  section.one_of = std::move(one_of);
  return nested(key, Kind::table, std::move(section), std::move(doc)).default_is(absent);
}

Field limit(const char* key, const char* doc, const char* otherwise) {
  return optional_table(
      key,
      {number("youngs_modulus", "Pa", positive(), "Along the axis.").called("modulus").required(),
       number("poisson_ratio", "", strictly_between(-1.0, 1.0), "Of the plane normal to it, sqrt(nu_ij nu_ji).")
           .called("ratio")
           .required(),
       number("plastic_scale", "", positive(1e3), "Along it.").called("factor").standard(1.0)},
      doc, otherwise);
}

} // namespace

Field reorient_field() {
  return optional_table(
      "reorient",
      {number("length_over_width", "", positive(1e6), "Of a grain; below 1: a disc, whose direction is its normal.")
           .called("ratio")
           .required(),
       limit("isotropic", "An axis when grains point anywhere.", "between the material's axes"),
       limit("parallel", "An axis when all grains point along it.", "the material's z axis"),
       limit("perpendicular", "An axis when all grains point across it.", "the material's x axis")},
      "Grains turn with the flow, and what the material is along its axes follows them.",
      "none: grains keep their place in the frame");
}

Field sub_particles_field() {
  const Interval length = positive(1e6);
  return optional_table(
      "sub_particles",
      {integer("per_particle", between(1, 1000), "Grains per particle.").standard(4),
       choice("shape",
              {{"rod", "", ""},
               {"straw", "", ""},
               {"card", "", ""},
               {"coin", "", ""},
               {"brick", "", ""},
               {"sphere", "", ""}},
              "How a grain is drawn; its length, or a card's normal, is along the fibre.")
           .standard("rod"),
       plain("mesh", Kind::path, "An artist mesh (obj, ply, stl, gltf, glb, fbx, ...) that every grain is drawn as.")
           .default_is("none: the shape"),
       choice("mesh_along", {{"x", "", ""}, {"y", "", ""}, {"z", "", ""}},
              "The axis of the mesh's file that is laid along the fibre, or a card's normal.")
           .standard("z"),
       numbers(
           "size", 3, "m", length,
           "Of a grain along the material's x, y, z; z is the fibre, or a card's normal. A mesh is stretched to it.")
           .called("lengths")
           .default_is("that of the mesh, in m; a shape needs it"),
       number("size_variation", "", between(0.0, 1.0), "Standard deviation of the size, relative.")
           .called("number")
           .standard(0.15),
       number("spread_deg", "degrees", between(0.0, 90.0),
              "Standard deviation of a grain's direction from the fibre's.")
           .called("angle")
           .standard(6.0),
       integer("seed", between(0, 1e9), "Another number, another heap.").standard(1),
       number("escape_density", "", strictly_between(0.0, 1.0),
              "Below this share of the material's density, or a quarter of capture_density, a grain flies by itself.")
           .called("share")
           .standard(0.005),
       number("capture_density", "", strictly_between(0.0, 10.0),
              "Above this share a flying grain is carried again; above 1: hardly ever.")
           .called("share")
           .standard(0.2),
       number("travel", "cells", between(0.0, 0.5),
              "How far a grain may go between two updates; less is more accurate.")
           .called("number")
           .standard(0.25)},
      "Grains that are drawn in place of the particles: they follow the matter and do not act on it.",
      "none: particles are drawn as spheres", {{{{"shape"}, {"mesh", "mesh_along"}}, false, "form"}});
}

} // namespace wry::shots
