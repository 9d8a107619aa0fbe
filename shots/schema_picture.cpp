#include "shots/schema.h"

namespace wry::shots {
namespace {

Interval unit_interval() {
  return between(0.0, 1.0);
}

Field camera_field() {
  Section section;
  section.doc = "Where the picture is taken from: on an orbit framed to the whole sequence, or a position.";
  section.effect = Effect::pictures;
  section.fields = {
      numbers("position", 3, "m", between(-1e9, 1e9), "A fixed place, in place of an orbit.")
          .default_is("on the orbit"),
      numbers("target", 3, "m", between(-1e9, 1e9), "What it looks at.")
          .default_is("the middle of the sequence's bounds"),
      number("azimuth_deg", "degrees", between(-3600, 3600), "Angle of the orbit about up; 0 is in front.")
          .called("angle")
          .standard(30.0),
      number("elevation_deg", "degrees", between(-89, 89), "Angle above the horizon.").called("angle").standard(12.0),
      number("distance", "m", positive(1e9), "From the target.")
          .called("distance")
          .or_word("auto", "so that everything fits"),
      number("lens", "mm", between(10, 1000), "Focal length on a film 36 mm wide.")
          .called("focal length")
          .standard(50.0),
      number("margin", "", between(0.0, 0.9), "Part of the picture left free around the subject.").standard(0.1),
  };
  section.one_of = {{{{"position"}, {"azimuth_deg", "elevation_deg", "distance", "margin"}}, false, "view point"}};
  return nested("camera", Kind::table, section, section.doc);
}

Field ground_field() {
  Section section;
  section.doc = "The floor that shadows fall on.";
  section.effect = Effect::pictures;
  section.fields = {
      boolean("show", "Whether it is drawn.").standard(true),
      number("height", "m", between(-1e9, 1e9), "Where it lies along up.")
          .called("height")
          .or_word("auto", "the first plane collider, or the lowest point"),
      plain("colour", Kind::colour, "Its colour, sRGB: [r, g, b] in 0..1 or \"#rrggbb\".")
          .standard(number_list({0.42, 0.42, 0.43})),
  };
  return nested("ground", Kind::table, section, section.doc);
}

Field turntable_field() {
  Section section;
  section.doc = "One frame seen from all around, for `wry turntable`.";
  section.effect = Effect::pictures;
  section.fields = {
      integer("frames", between(2, 10'000), "Pictures of one turn; the last is not the first again.").standard(96),
      integer("frame", between(0, 1e7), "The frame that turns.").or_word("last", "the last frame"),
  };
  return nested("turntable", Kind::table, section, section.doc);
}

Field heat_field() {
  Section section;
  section.doc = "The ends of a heat map's colour bar; the name is the channel.";
  section.effect = Effect::pictures;
  section.fields = {
      number("min", "", any_number(), "The lower end.").default_is("the least value of the sequence"),
      number("max", "", any_number(), "The upper end.").default_is("the greatest value of the sequence"),
  };
  return nested("heat", Kind::named_tables, section, section.doc);
}

} // namespace

Section look_section() {
  Section section;
  section.doc = "How a body is drawn.";
  section.effect = Effect::pictures;
  section.fields = {
      plain("colour", Kind::colour, "Base colour, sRGB: [r, g, b] in 0..1 or \"#rrggbb\".")
          .standard(number_list({0.72, 0.70, 0.67})),
      number("roughness", "", between(0.05, 1.0), "0.05: polished, 1: chalk.").standard(0.5),
      number("metallic", "", unit_interval(), "0: plastic, cloth, stone; 1: metal.").standard(0.0),
      number("specular", "", between(0.0, 0.2), "Reflectance seen straight on, of what is no metal.").standard(0.04),
      number("wrap", "", unit_interval(), "How far light creeps around soft matter.").standard(0.0),
  };
  section.later = {{"texture", "textures"}, {"variation", "variation per grain"}};
  return section;
}

Section render_section() {
  Section section;
  section.doc = "How frames become pictures.";
  section.effect = Effect::pictures;
  section.fields = {
      integers("size", 2, between(16, 16'384), "Width and height in pixels.")
          .standard(Value(Array{Value(std::int64_t{1920}), Value(std::int64_t{1080})})),
      integer("samples", between(1, 4096), "Jittered sub-frames per picture.").standard(8),
      plain("views", Kind::view_list, "What is drawn: beauty, clay, wire, heat.<channel>.")
          .standard(text_list({"beauty"})),
      camera_field(),
      number("exposure", "stops", between(-20, 20), "Brightness.").standard(0.0),
      ground_field(),
      plain("background", Kind::colour, "Behind everything, sRGB: [r, g, b] in 0..1 or \"#rrggbb\".")
          .standard(number_list({0.58, 0.60, 0.63})),
      boolean("slate", "Shot, frame, time and wedge burnt into the picture.").standard(false),
      boolean("shadows", "Whether lights cast shadows.").standard(true),
      turntable_field(),
      heat_field(),
  };
  section.later = {
      {"lights", "lights of a shot's own"}, {"motion_blur", "motion blur"}, {"depth_of_field", "depth of field"}};
  return section;
}

} // namespace wry::shots
