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
  look.like = reader.optional_text("like");
  look.scatter = reader.optional_vector("scatter");
  look.clearcoat = reader.number("clearcoat");
  look.clearcoat_roughness = reader.number("clearcoat_roughness");
  look.transparency = reader.number("transparency");
  look.colour_variation = reader.number("colour_variation");
  look.size_variation = reader.number("size_variation");
  look.own_materials = reader.boolean("own_materials");
  return look;
}

FrictionOptions bind_friction(const Reader& reader) {
  return {reader.number("friction"), reader.optional_number("sliding_friction")};
}

ContactOptions bind_contact(const Reader& reader) {
  ContactOptions contact;
  contact.source = reader.source();
  contact.between = reader.boolean("between");
  contact.within = reader.boolean("within");
  contact.friction = bind_friction(reader);
  for (const auto& [name, pair] : reader.named_children("pair"))
    contact.pairs.push_back({pair.text("first"), pair.text("second"), bind_friction(pair)});
  return contact;
}

Located<PointRotations> bind_point_rotations(const Reader& reader, const char* key) {
  using P = PointRotations;
  return reader.choice<P>(key, {{"velocity", P::velocity},
                                {"rotation-vectors", P::rotation_vectors},
                                {"quaternion-blend", P::quaternion_blend},
                                {"spherical", P::spherical}});
}

FemOptions bind_fem(const Reader& reader) {
  FemOptions fem;
  fem.source = reader.source();
  fem.integrator = reader.choice<Integrator>(
      "integrator",
      {{"backward-euler", Integrator::backward_euler}, {"bdf2", Integrator::bdf2}, {"sdirk2", Integrator::sdirk2}});
  fem.rotation_update = reader.choice<RotationUpdate>(
      "rotation_update", {{"cayley", RotationUpdate::cayley}, {"exponential", RotationUpdate::exponential}});
  fem.point_rotations = bind_point_rotations(reader, "point_rotations");
  fem.reset_every = reader.integer("reset_every");
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
                                           {"strain_energy", K::strain_energy},
                                           {"run_out", K::run_out},
                                           {"front_position", K::front_position},
                                           {"pile_height", K::pile_height},
                                           {"repose_angle", K::repose_angle},
                                           {"fraction_outside", K::fraction_outside},
                                           {"curvature_energy", K::curvature_energy},
                                           {"bound_low", K::bound_low},
                                           {"bound_high", K::bound_high},
                                           {"tip_position", K::tip_position},
                                           {"momentum", K::momentum},
                                           {"angular_momentum", K::angular_momentum},
                                           {"reaction_force", K::reaction_force},
                                           {"reaction_torque", K::reaction_torque},
                                           {"element_twist_max", K::element_twist_max},
                                           {"rotation_distance", K::rotation_distance},
                                           {"curvature_error", K::curvature_error},
                                           {"rotation_interpolation_error", K::rotation_interpolation_error},
                                           {"curve_radius", K::curve_radius},
                                           {"curve_pitch", K::curve_pitch},
                                           {"mean_alignment", K::mean_alignment},
                                           {"second_moment", K::second_moment},
                                           {"largest_fragment", K::largest_fragment},
                                           {"grains_inside", K::grains_inside},
                                           {"grain_hover", K::grain_hover},
                                           {"crossings", K::crossings}});
  measure.body = reader.text("body");
  if (const auto axis = reader.optional_text("axis")) {
    measure.axis = Located<Axis>(axis_of(**axis), axis->source);
  }
  measure.about = reader.optional_vector("about");
  measure.at = reader.choice<MeasureAt>(
      "at", {{"nodes", MeasureAt::nodes}, {"points", MeasureAt::points}, {"centroid", MeasureAt::centroid}});
  measure.rule = bind_point_rotations(reader, "rule");
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
  expectation.every_frame = reader.boolean("every_frame");
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
  for (const Reader& drive : root.children("drive")) {
    shot.drives.push_back(bind_drive(drive, *shot.shot.up));
  }
  for (const Reader& load : root.children("load")) {
    shot.loads.push_back(bind_load(load));
  }
  for (const Reader& collider : root.children("collider")) {
    shot.colliders.push_back(bind_collider(collider, directory, *shot.shot.up));
  }
  for (const auto& [name, look] : root.named_children("look")) {
    shot.looks.push_back(bind_look(look, name));
  }
  shot.fem = bind_fem(root.child("fem"));
  if (root.has("contact")) {
    shot.contact = bind_contact(root.child("contact"));
  }
  shot.mpm = bind_mpm(root.child("mpm"));
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
