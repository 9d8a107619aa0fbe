#include "shots/schema.h"

namespace wry::shots {
namespace {

std::vector<Choice> like_words() {
  std::vector<Choice> words;
  for (const char* name : {"clay", "rubber", "skin", "straw", "wood", "card", "metal", "ceramic", "paint", "glass",
                           "sand", "snow", "brick"})
    words.push_back({name, "", ""});
  return words;
}

Interval unit_interval() {
  return between(0.0, 1.0);
}

Section camera_key_section() {
  Section section;
  section.doc = "A place of the camera at a frame.";
  section.effect = Effect::pictures;
  section.fields = {
      integer("frame", between(0, 1e7), "When it is there.").required(),
      numbers("position", 3, "m", between(-1e9, 1e9), "Where it is.").required(),
      numbers("target", 3, "m", between(-1e9, 1e9), "What it looks at.")
          .default_is("the middle of the sequence's bounds"),
      number("lens", "mm", between(10, 1000), "Focal length.").called("focal length").default_is("the camera's lens"),
  };
  return section;
}

Field depth_of_field_field() {
  Section section;
  section.doc = "A real lens: what is nearer or farther than the focus blurs. It needs 8 samples or more.";
  section.effect = Effect::pictures;
  section.fields = {
      number("f_stop", "", between(0.01, 128), "The f-number; the scene's metres are real metres.").required(),
      number("focus", "m", positive(1e9), "Distance that is sharp.")
          .called("distance")
          .or_word("subject", "the middle of the sequence's bounds"),
  };
  return nested("depth_of_field", Kind::table, section, section.doc);
}

Field lights_field() {
  Section section;
  section.doc = "What lights the picture.";
  section.effect = Effect::pictures;
  section.fields = {
      choice("rig",
             {{"studio", "key, fill and rim light, a soft sky and the floor's bounce", ""},
              {"day", "sun and sky outdoors", ""},
              {"image", "an HDR picture of the surroundings", ""}},
             "The rig.")
          .standard("studio"),
      plain("image", Kind::path, "Equirectangular .hdr or .exr, for rig = \"image\".").default_is("none"),
      number("turn_deg", "degrees", between(-3600, 3600), "Turns all lights about up.").called("angle").standard(0.0),
      number("stops", "stops", between(-20, 20), "Brightness of the lights, without that of the lens.").standard(0.0),
      choice("turn_with",
             {{"camera", "the subject turns under fixed lights", ""}, {"world", "the lights stand in the world", ""}},
             "What the lights stand still against.")
          .default_is("camera for the studio, world for the others"),
      boolean("show_image", "Whether the surroundings are seen behind the subject.").standard(false),
  };
  return nested("lights", Kind::table, section, section.doc);
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
      reference("look_at", "body", "The name of a body whose middle the camera keeps looking at.")
          .default_is("the target"),
      number("orbit_turns", "turns", between(-1000, 1000), "How far it goes round while the sequence plays.")
          .called("angle")
          .standard(0.0),
      nested("keys", Kind::table_list, camera_key_section(), "Places over time; between them it moves smoothly.")
          .default_is("it stands still"),
      plain("file", Kind::path, "A glTF or FBX file with an animated camera.").default_is("no file"),
      plain("node", Kind::text, "The camera in that file.").default_is("its first"),
  };
  section.one_of = {{{{"position"}, {"azimuth_deg", "elevation_deg", "distance", "margin"}, {"keys"}, {"file"}},
                     false,
                     "view point"}};
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
      boolean("catch_shadow", "Only its shadow is drawn, as alpha, to lay over another picture.").standard(false),
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
      boolean("moving", "The sequence plays while it turns, over and over.").standard(false),
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
      choice("like", like_words(), "A built-in look to start from; the keys given here win.").default_is("none"),
      plain("scatter", Kind::colour, "Colour of the light that creeps, sRGB.").default_is("the base colour's"),
      number("clearcoat", "", unit_interval(), "A second, smooth layer: lacquer, glaze, wet paint.").standard(0.0),
      number("clearcoat_roughness", "", between(0.05, 1.0), "How rough that layer is.").standard(0.1),
      number("transparency", "", unit_interval(), "How much is seen through it: glass, clear plastic.").standard(0.0),
      number("colour_variation", "", between(0.0, 0.6), "How much grains differ in colour.").standard(0.0),
      number("size_variation", "", between(0.0, 0.9), "How much grains differ in size.").standard(0.0),
      boolean("own_materials", "The body wears the materials and pictures of its mesh file.").standard(false),
  };
  section.later = {{"texture", "textures of a look's own; own_materials takes those of the mesh file"}};
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
      plain("views", Kind::view_list, "What is drawn: beauty, clay, wire, heat.<channel>, directors, fibres, contacts.")
          .standard(text_list({"beauty"})),
      camera_field(),
      number("exposure", "stops", between(-20, 20), "Brightness.").standard(0.0),
      ground_field(),
      plain("background", Kind::colour, "Behind everything, sRGB: [r, g, b] in 0..1 or \"#rrggbb\".")
          .standard(number_list({0.58, 0.60, 0.63})),
      boolean("slate", "Shot, frame, time and wedge burnt into the picture.").standard(false),
      boolean("shadows", "Whether lights cast shadows.").standard(true),
      lights_field(),
      number("motion_blur", "", unit_interval(), "Open time of the shutter as a part of a frame; 0.5 is film's.")
          .standard(0.0),
      depth_of_field_field(),
      choice("tone",
             {{"filmic", "a soft shoulder: bright colours run to white", ""}, {"plain", "the sRGB curve alone", ""}},
             "How light becomes pixels.")
          .standard("filmic"),
      choice("bits", {{"8", "", ""}, {"16", "", ""}}, "Depth of the PNG files, per channel.").standard("8"),
      boolean("alpha", "The background is left clear, with straight alpha.").standard(false),
      word_list("exr",
                {{"colour", "linear light", ""},
                 {"Z", "distance along the view axis [m]", ""},
                 {"N", "normal in the world", ""},
                 {"velocity", "in the world [m/s]", ""},
                 {"id", "body, from 1", ""}},
                "Layers of an OpenEXR file beside each picture; linear Rec. 709.")
          .default_is("no such file"),
      boolean("contact_sheet", "A sheet of frames beside the pictures.").standard(false),
      turntable_field(),
      heat_field(),
  };
  return section;
}

} // namespace wry::shots
