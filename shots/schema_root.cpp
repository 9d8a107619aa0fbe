#include "shots/schema.h"

namespace wry::shots {
namespace {

Section root_section() {
  Section root;
  root.doc = "The shot file: TOML 1.0, SI units, degrees only where a key says so, paths relative to the shot file.";
  root.fields = {
      plain("extends", Kind::path,
            "Another shot file that this one starts from; this file's keys win, array tables are merged by name.")
          .affects(Effect::nothing),
      nested("shot", Kind::table, shot_section(), "Name, frames and what holds for the whole scene."),
      nested("body", Kind::named_list, body_section(), "A solid: its shape, where it stands, what it is made of."),
      nested("material", Kind::named_tables, material_section(),
             "How matter resists; the model decides which solver a body needs."),
      nested("fixed", Kind::named_list, fixed_section(), "Nodes that are held where they rest."),
      nested("drive", Kind::named_list, drive_section(), "Nodes that are moved along keys."),
      nested("load", Kind::named_list, load_section(), "Forces and torques that act on nodes."),
      nested("collider", Kind::named_list, collider_section(), "An obstacle that bodies rest on."),
      nested("look", Kind::named_tables, look_section(), "How a body is drawn."),
      nested("fem", Kind::table, fem_section(), "How solids are solved."),
      nested("contact", Kind::table, contact_section(),
             "Contact between bodies and within them; without this table bodies feel colliders only.")
          .default_is("no contact of bodies"),
      nested("mpm", Kind::table, mpm_section(), "How the material point method runs."),
      nested("render", Kind::table, render_section(), "How frames become pictures."),
      nested("measure", Kind::named_list, measure_section(), "A named scalar per frame, a column of measure.csv."),
      nested("expect", Kind::named_tables, expect_section(),
             "A range that a measure has to keep; else `wry run` ends with 1."),
      plain("sweep", Kind::free,
            "Variants: quoted keys of this file, each with a list of values or a range; [[sweep.case]] for named ones.")
          .affects(Effect::nothing),
      plain("accuracy", Kind::free, "Ladders for `wry accuracy`: error against run time.").affects(Effect::nothing),
      plain("stress", Kind::free, "Knobs for `wry stress`: where the shot holds, and where it does not.")
          .affects(Effect::nothing),
  };
  root.later = {
      {"light", "lights of a shot's own"},
      {"export", "exports from the shot file"},
  };
  return root;
}

} // namespace

const Section& shot_schema() {
  static const Section schema = root_section();
  return schema;
}

Section shot_section() {
  Section section;
  section.doc = "Name, frames and what holds for the whole scene.";
  section.fields = {
      plain("name", Kind::name, "Names the output folder and the pictures.")
          .default_is("the file's name")
          .affects(Effect::nothing),
      plain("frames", Kind::frames,
            "Frames to deliver: 1-120, 1001-1100x2,1150. The first is time 0; steps land on all.")
          .standard("1-48")
          .affects(Effect::nothing),
      number("fps", "1/s", positive(1e5), "Frames per second; frame f is at (f - first)/fps.")
          .called("rate")
          .standard(24.0),
      choice("up", {{"x", "", ""}, {"y", "", ""}, {"z", "", ""}}, "The axis that points up.").standard("y"),
      numbers("gravity", 3, "m/s^2", between(-1e6, 1e6), "Gravity.").default_is("9.81 against up"),
      integer("seed", between(0, 9e15), "Seed of everything random in the shot.").standard(1),
  };
  return section;
}

} // namespace wry::shots
