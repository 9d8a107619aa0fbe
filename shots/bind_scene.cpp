#include "shots/bind.h"

namespace wry::shots {
namespace {

ShotSettings bind_settings(const Reader& reader) {
  ShotSettings settings;
  settings.name = reader.text("name");
  const Located<std::string> frames = reader.text("frames");
  Result<FrameRange> range = FrameRange::parse(*frames);
  settings.frames = Located<FrameRange>(range ? std::move(range).value() : FrameRange(), frames.source);
  settings.fps = reader.number("fps");
  const Located<std::string> up = reader.text("up");
  settings.up = Located<Axis>(axis_of(*up), up.source);
  settings.gravity = reader.vector("gravity");
  settings.seed = reader.integer("seed");
  return settings;
}

Fixed bind_fixed(const Reader& reader) {
  Fixed fixed;
  fixed.source = reader.source();
  fixed.name = reader.text("name");
  fixed.body = reader.text("body");
  fixed.where = bind_region(reader.child("where"));
  fixed.until = reader.optional_number("until");
  const Source hold = reader.text("hold").source;
  fixed.hold_positions = fixed.hold_microrotations = Located<bool>(false, hold);
  for (const Located<std::string>& word : reader.texts("hold")) {
    (*word == "positions" ? fixed.hold_positions : fixed.hold_microrotations).value = true;
  }
  return fixed;
}

Look bind_look(const Reader& reader, const std::string& name) {
  Look look;
  look.source = reader.source();
  look.name = Located<std::string>(name, reader.source());
  look.colour = reader.vector("colour");
  look.roughness = reader.number("roughness");
  look.metallic = reader.number("metallic");
  look.specular = reader.number("specular");
  look.wrap = reader.number("wrap");
  return look;
}

FemOptions bind_fem(const Reader& reader) {
  FemOptions fem;
  fem.source = reader.source();
  fem.integrator = reader.choice<Integrator>("integrator", {{"backward-euler", Integrator::backward_euler}});
  fem.time_step = reader.optional_number("time_step");
  fem.min_time_step = reader.number("min_time_step");
  fem.newton_tolerance = reader.number("newton_tolerance");
  fem.max_newton_iterations = reader.integer("max_newton_iterations");
  fem.linear_solver = reader.choice<LinearSolver>("linear_solver", {{"auto", LinearSolver::automatic},
                                                                    {"pcg", LinearSolver::pcg},
                                                                    {"cholesky", LinearSolver::cholesky},
                                                                    {"stale-cholesky", LinearSolver::stale_cholesky}});
  fem.linear_tolerance = reader.optional_number("linear_tolerance");
  fem.contact_distance = reader.optional_number("contact_distance");
  fem.contact_stiffness = reader.optional_number("contact_stiffness");
  fem.friction_velocity = reader.number("friction_velocity");
  fem.checkpoint_every = reader.integer("checkpoint_every");
  fem.keep = reader.integer("keep");
  return fem;
}

Measure bind_measure(const Reader& reader) {
  using K = MeasureKind;
  Measure measure;
  measure.source = reader.source();
  measure.name = reader.text("name");
  measure.kind = reader.choice<K>("kind", {{"height", K::height},
                                           {"extent", K::extent},
                                           {"lowest", K::lowest},
                                           {"centre", K::centre},
                                           {"volume", K::volume},
                                           {"speed", K::speed},
                                           {"kinetic_energy", K::kinetic_energy},
                                           {"strain_energy", K::strain_energy}});
  measure.body = reader.text("body");
  if (const auto axis = reader.optional_text("axis")) {
    measure.axis = Located<Axis>(axis_of(**axis), axis->source);
  }
  if (reader.has("where")) {
    measure.where = bind_region(reader.child("where"));
  }
  measure.relative = reader.boolean("relative");
  return measure;
}

Expectation bind_expectation(const Reader& reader, const std::string& name) {
  Expectation expectation;
  expectation.source = reader.source();
  expectation.name = Located<std::string>(name, reader.source());
  expectation.measure = reader.text("measure");
  expectation.frame = reader.optional_integer("frame");
  expectation.min = reader.optional_number("min");
  expectation.max = reader.optional_number("max");
  expectation.sweep_case = reader.optional_text("case");
  expectation.ratio_to = reader.optional_text("ratio_to");
  return expectation;
}

} // namespace

Region bind_region(const Reader& reader) {
  if (reader.has("box")) {
    const Reader box = reader.child("box");
    return BoxRegion{box.vector("min"), box.vector("max")};
  }
  if (reader.has("sphere")) {
    const Reader sphere = reader.child("sphere");
    return SphereRegion{sphere.vector("centre"), sphere.number("radius")};
  }
  if (reader.has("cylinder")) {
    const Reader cylinder = reader.child("cylinder");
    return CylinderRegion{cylinder.vector("from"), cylinder.vector("to"), cylinder.number("radius")};
  }
  if (reader.has("attribute")) {
    return AttributeRegion{reader.text("attribute")};
  }
  return ExpressionRegion{reader.expression("expression")};
}

Shot bind_shot(const Table& checked, const std::string& file, const std::string& directory, ReadLog* log) {
  const Reader root(checked, "", Place{}, log);
  Shot shot;
  shot.file = file;
  shot.directory = directory;
  shot.shot = bind_settings(root.child("shot"));
  for (const Reader& body : root.children("body")) {
    shot.bodies.push_back(bind_body(body, directory));
  }
  for (const auto& [name, material] : root.named_children("material")) {
    shot.materials.push_back(bind_material(material, name));
  }
  for (const Reader& fixed : root.children("fixed")) {
    shot.fixed.push_back(bind_fixed(fixed));
  }
  for (const Reader& collider : root.children("collider")) {
    shot.colliders.push_back(bind_collider(collider, directory, *shot.shot.up));
  }
  for (const auto& [name, look] : root.named_children("look")) {
    shot.looks.push_back(bind_look(look, name));
  }
  shot.fem = bind_fem(root.child("fem"));
  shot.render = bind_render(root.child("render"));
  for (const Reader& measure : root.children("measure")) {
    shot.measures.push_back(bind_measure(measure));
  }
  for (const auto& [name, expectation] : root.named_children("expect")) {
    shot.expectations.push_back(bind_expectation(expectation, name));
  }
  shot.sweep_case = root.child("sweep").optional_text("applied");
  return shot;
}

} // namespace wry::shots
