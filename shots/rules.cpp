#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "shots/bind.h"
#include "shots/check.h"

namespace wry::shots {
namespace {

/// Rules that need more than one key; each looks only at things whose keys are all right by themselves.
class Rules {
public:
  Rules(const Shot& shot, Diagnostics& diagnostics)
      : m_shot(shot)
      , m_diagnostics(diagnostics) {}

  void check() {
    if (m_shot.bodies.empty() && !m_diagnostics.any_under("body")) {
      m_diagnostics.add(Source{m_shot.file, 1, 1, "body", Origin::file},
                        " is missing: a shot needs at least one [[body]]");
    }
    for (const Body& body : m_shot.bodies) {
      if (sound(body)) {
        check_body(body);
      }
    }
    for (const Material& material : m_shot.materials) {
      if (sound(material)) {
        check_material(material);
      }
    }
    for (const Fixed& fixed : m_shot.fixed) {
      if (sound(fixed)) {
        need_body(*fixed.body, fixed.source);
        check_region(fixed.where);
      }
    }
    for (const Collider& collider : m_shot.colliders) {
      if (sound(collider)) {
        check_collider(collider);
      }
    }
    for (const Drive& drive : m_shot.drives) {
      if (sound(drive)) {
        need_body(*drive.body, drive.source);
        check_region(drive.where);
        check_drive(drive);
      }
    }
    for (const Load& load : m_shot.loads) {
      if (sound(load)) {
        need_body(*load.body, load.source);
        if (load.where) {
          check_region(*load.where);
        }
        check_load(load);
      }
    }
    for (const Measure& measure : m_shot.measures) {
      if (sound(measure)) {
        check_measure(measure);
      }
    }
    for (const Expectation& expectation : m_shot.expectations) {
      if (sound(expectation)) {
        check_expectation(expectation);
      }
    }
    check_settings();
  }

private:
  template <class Item> bool sound(const Item& item) const { return !m_diagnostics.any_under(item.source.key); }

  void refuse(Source source, std::string message) { m_diagnostics.add(std::move(source), std::move(message)); }
  static Source below(Source source, const std::string& key) {
    source.key += "." + key;
    return source;
  }

  /// Keys of one method on a body of the other.
  void check_particles(const Body& body) {
    const auto refuse_solid = [&](const auto& key) {
      if (key) {
        refuse(key->source, ": only solids are cut into tets; particles_per_cell says how finely this body is sampled");
      }
    };
    refuse_solid(body.resolution);
    refuse_solid(body.cells);
    const ParticleBody& particles = body.particles;
    if (particles.region) {
      if (const auto* box = std::get_if<BoxSpace>(&particles.region->space)) {
        for (Eigen::Index i = 0; i < 3; ++i) {
          if (!((*box->min)[i] < (*box->max)[i])) {
            refuse(box->max.source,
                   fmt::format(": along {} the box ends at {}, not above its beginning {}; it is empty", "xyz"[i],
                               (*box->max)[i], (*box->min)[i]));
            return;
          }
        }
      }
      if (const auto* space = std::get_if<CylinderSpace>(&particles.region->space);
          space && *space->from == *space->to) {
        refuse(space->to.source, ": both ends of the axis are the same point; a cylinder needs a length");
      }
    }
    if (particles.fibre && particles.fibre->second_moment) {
      const Located<Vec3>& shares = *particles.fibre->second_moment;
      if (std::abs(shares->sum() - 1.0) > 1e-6) {
        refuse(shares.source, fmt::format(": the shares sum to {:.6g}; expected 1", shares->sum()));
      }
    }
    if (particles.grains && !particles.grains->mesh && !particles.grains->size) {
      refuse(below(particles.grains->source, "size"),
             " is missing: give the lengths of a grain along the material's x, y, z in m, or a mesh that has them");
    }
    if (particles.repeat && particles.grains) {
      refuse(particles.grains->source, ": a source has no sub_particles in this build; remove one of the two");
    }
    if (particles.repeat && body.velocity->norm() == 0.0) {
      refuse(particles.repeat->source, ": a source whose matter stands still piles up in place; give velocity");
    }
    if (particles.fibre && particles.fibre->azimuth_deg.source.origin != Origin::standard &&
        !particles.fibre->tilt_deg) {
      refuse(particles.fibre->azimuth_deg.source, ": needs tilt_deg, the angle from up");
    }
  }

  void check_body(const Body& body) {
    if (m_shot.is_particles(body)) {
      check_particles(body);
      return;
    }
    const ParticleBody& particles = body.particles;
    const auto refuse_particles = [&](const auto& key) {
      if (key) {
        refuse(key->source, fmt::format(": {} is not of model = \"mpm\", so this body has no particles",
                                        body.material->empty() ? "its material" : *body.material));
      }
    };
    refuse_particles(particles.region);
    refuse_particles(particles.fibre);
    refuse_particles(particles.repeat);
    refuse_particles(particles.grains);
    if (particles.region) {
      return;
    }
    const bool structured =
        std::holds_alternative<BoxShape>(body.shape) || std::holds_alternative<RodShape>(body.shape) ||
        std::holds_alternative<SheetShape>(body.shape) || std::holds_alternative<CylinderShape>(body.shape);
    const auto* mesh = std::get_if<MeshShape>(&body.shape);
    if (body.cells && !structured) {
      refuse(body.cells->source,
             ": only a box, rod, sheet or cylinder is made of cells; give resolution, an edge in m");
    }
    if (!body.cells && !body.resolution && !(mesh && mesh->is_tet_mesh)) {
      refuse(below(body.source, "resolution"),
             fmt::format(" is missing: give the target edge in m{}", structured ? ", or cells = [nx, ny, nz]" : ""));
    }
    constexpr double MOST_CELLS = 2e7;
    if (body.cells) {
      const auto& n = body.cells->value;
      const double count = static_cast<double>(n[0]) * static_cast<double>(n[1]) * static_cast<double>(n[2]);
      if (count > MOST_CELLS) {
        refuse(body.cells->source, fmt::format(": {:g} cells; at most {:g} are possible", count, MOST_CELLS));
      }
    }
    if (body.shell && mesh && mesh->is_tet_mesh) {
      refuse(body.shell->thickness.source,
             ": a tet mesh cannot be hollowed; give its surface as mesh, or remove shell");
    }
    if (body.shell && body.cells) {
      refuse(body.shell->thickness.source,
             ": what is made of cells cannot be hollowed; give resolution instead of cells");
    }
    check_mesh_only(body, mesh != nullptr);
    check_element(body);
    if (const auto* torus = std::get_if<TorusShape>(&body.shape); torus && *torus->tube_radius >= *torus->radius) {
      refuse(torus->tube_radius.source, fmt::format(" = {}: expected less than radius = {}, or the ring has no hole",
                                                    *torus->tube_radius, *torus->radius));
    }
  }

  void check_mesh_only(const Body& body, bool is_mesh) {
    const char* advice = ": only mesh files have it; primitives are in m and stand as they are, turn them with rotate";
    if (!is_mesh && *body.metres_per_unit != 1.0) {
      refuse(body.metres_per_unit.source, advice);
    }
    if (!is_mesh && body.up) {
      refuse(body.up->source, advice);
    }
  }

  void check_collider(const Collider& collider) {
    const auto* box = std::get_if<OpenBoxShape>(&collider.shape);
    const auto* mesh = std::get_if<ColliderMeshShape>(&collider.shape);
    if (box) {
      check_container(*box, collider.source);
    }
    if (std::holds_alternative<PlaneShape>(collider.shape) &&
        (!collider.rotate.empty() || collider.size || *collider.scale != 1.0 || !collider.translate->isZero(0.0))) {
      refuse(collider.source,
             ": a plane stands by its point (or height) and normal; remove rotate, translate, size and "
             "scale");
    }
    if (!mesh && *collider.motion.from == MotionFrom::file) {
      refuse(collider.motion.from.source, " = \"file\": only a mesh has a file to take its motion from");
    }
    if (mesh && mesh->sequence && mesh->node) {
      refuse(mesh->node->source, ": a sequence moves all of the file; remove node");
    }
    if (mesh && mesh->sequence && *collider.motion.from == MotionFrom::file) {
      refuse(collider.motion.from.source, " = \"file\": the mesh moves by its sequence; remove one of them");
    }
    if (*collider.motion.from == MotionFrom::file && !collider.motion.keys.empty()) {
      refuse(collider.motion.keys.front().source, ": motion = \"file\" takes no keys; remove one of them");
    }
    check_motion(collider.motion);
  }

  void check_container(const OpenBoxShape& box, const Source& source) {
    if (!box.open.empty() && !box.wall) {
      refuse(below(source, "box.wall"), " is missing: a box with open sides is its walls, and they need a thickness");
    }
    if (box.open.empty() && box.wall) {
      refuse(box.wall->source, ": the box has no open side, so it is solid; remove wall, or name a side in open");
    }
    if (box.wall && 2.0 * **box.wall >= box.size->minCoeff()) {
      refuse(box.wall->source, fmt::format(" = {}: expected less than half of the least length, {}", **box.wall,
                                           0.5 * box.size->minCoeff()));
    }
  }

  void check_motion(const Motion& motion) {
    for (std::size_t i = 1; i < motion.keys.size(); ++i) {
      const Located<double>& time = motion.keys[i].time;
      if (*time <= *motion.keys[i - 1].time) {
        refuse(time.source, fmt::format(" = {}: expected more than the {} s of the key before it; keys stand in order "
                                        "of time",
                                        *time, *motion.keys[i - 1].time));
        return;
      }
    }
  }

  void check_element(const Body& body) {
    const Material* material = m_shot.find_material(*body.material);
    if (material == nullptr || !sound(*material)) {
      return;
    }
    const bool plate = *material->model == MaterialModel::plate;
    const bool triangles = *body.element == Element::tri3 || *body.element == Element::tri6;
    if (triangles != plate && *body.element != Element::automatic) {
      refuse(body.element.source, plate ? ": a plate is made of triangles; expected \"tri3\" or \"tri6\""
                                        : ": triangles are elements of plates; expected \"tet4\" or \"tet10\", or "
                                          "material.model = \"plate\"");
    }
    const bool own_kernel = *body.element == Element::tet10 || *body.quadrature == Quadrature::one_point;
    const Located<std::string>& name = material->name;
    if (own_kernel && *material->model != MaterialModel::micropolar) {
      refuse(*body.element == Element::tet10 ? body.element.source : body.quadrature.source,
             fmt::format(": only material.model = \"micropolar\" has it, and '{}' is another", *name));
    }
    if (*body.element == Element::tet10 && *body.quadrature == Quadrature::one_point) {
      refuse(body.quadrature.source, " = \"one-point\": only tet4 can have it");
    }
    if (own_kernel && *material->microrotation == Microrotation::condensed) {
      refuse(material->microrotation.source, " = \"condensed\": only tet4 with full quadrature can have it");
    }
    if (own_kernel || plate) {
      check_linear_tets_only(body, *material);
    }
    if (plate && !material->thickness && !std::holds_alternative<SheetShape>(body.shape)) {
      refuse(below(material->source, "thickness"), " is missing: a plate that is no sheet needs its thickness in m");
    }
    if (plate && body.shell) {
      refuse(body.shell->thickness.source, ": a plate is a surface already; remove shell");
    }
    if (const auto* mesh = std::get_if<MeshShape>(&body.shape); plate && mesh && mesh->is_tet_mesh) {
      refuse(mesh->path.source, ": a plate is made of a surface, not of tets; give an obj, ply, ... file");
    }
  }

  void check_linear_tets_only(const Body& body, const Material& material) {
    const char* advice = ": only linear tets with the full quadrature (element = \"tet4\") have it";
    for (const auto* factor : {&material.vary.density, &material.vary.youngs_modulus,
                               &material.vary.couple_modulus_ratio, &material.vary.length_scale}) {
      if (*factor) {
        refuse((*factor)->source, advice);
      }
    }
    for (const auto& turn : body.rest_rotation) {
      if (turn) {
        refuse(turn->source, advice);
      }
    }
    if (*m_shot.fem.point_rotations != PointRotations::velocity) {
      refuse(m_shot.fem.point_rotations.source, advice);
    }
  }

  void check_condensed(const Material& material) {
    if (*material.microrotation != Microrotation::condensed) {
      return;
    }
    if (*material.model != MaterialModel::micropolar || *material.length_scale > 0.0 ||
        *material.rotary_inertia > 0.0 || *material.couple_modulus_ratio < 1.0) {
      refuse(material.microrotation.source,
             " = \"condensed\": expected model = \"micropolar\", length_scale = 0, rotary_inertia = 0 and "
             "couple_modulus_ratio >= 1, or the rotation of the matter is not the microrotation of least energy");
    }
  }

  void check_plate_only(const Material& material) {
    if (*material.model == MaterialModel::plate) {
      if (*material.curvature.model == CurvatureModel::orthotropic) {
        refuse(material.curvature.model.source, " = \"orthotropic\": plates have the isotropic one");
      }
      if (*material.bending == PlateBending::curv && *material.length_scale == 0.0) {
        refuse(material.bending.source, " = \"curv\" needs length_scale > 0, or nothing resists bending");
      }
      return;
    }
    for (const std::optional<Located<double>>* only : {&material.thickness, &material.max_stretch}) {
      if (*only) {
        refuse((*only)->source, ": only plates have it; write model = \"plate\", or remove it");
      }
    }
  }

  void check_material(const Material& material) {
    if (*material.model == MaterialModel::mpm) {
      if (material.matter.reorient &&
          (material.matter.plastic_map || material.matter.stress_map || material.matter.strain_map)) {
        refuse(material.matter.reorient->source,
               ": grains that reorient have their maps from the limits; remove plastic_map, stress_map and strain_map");
      }
      return; // what its numbers allow is for sim/mpm to say
    }
    for (const Source& given : material.matter.given) {
      refuse(given, ": only model = \"mpm\" reads this key; remove it");
    }
    for (const PerAxis* value : {&material.matter.youngs_modulus, &material.matter.poisson_ratio}) {
      if (value->is_table) {
        Source source = value->values[0].source;
        source.key = source.key.substr(0, source.key.rfind('.'));
        refuse(source, ": only model = \"mpm\" is stiffer along one axis than along another; give one number");
        return;
      }
    }
    check_condensed(material);
    check_plate_only(material);
    if (is_micropolar(*material.model) && *material.couple_modulus_ratio == 0.0 && *material.length_scale == 0.0 &&
        *material.rotary_inertia == 0.0) {
      refuse(material.couple_modulus_ratio.source,
             " = 0: with length_scale = 0 and rotary_inertia = 0 nothing holds the microrotations; expected one of the "
             "three above 0, or model = \"neo-hookean\"");
    }
    const Curvature& curvature = material.curvature;
    *curvature.model == CurvatureModel::isotropic ? check_isotropic(curvature) : check_orthotropic(curvature);
  }

  void check_isotropic(const Curvature& curvature) {
    for (const auto& row : curvature.stiffness) {
      for (const auto& entry : row) {
        if (*entry > 0.0) {
          refuse(entry.source, ": stiffness is of the orthotropic model; write curvature.model = \"orthotropic\"");
          return;
        }
      }
    }
    if (*curvature.alpha + 3.0 * *curvature.gamma < 0.0) {
      refuse(curvature.gamma.source,
             fmt::format(" = {}: expected gamma >= -alpha/3 = {:.6g}, or the energy of curvature "
                         "has no least value",
                         *curvature.gamma, -*curvature.alpha / 3.0));
    }
  }

  void check_orthotropic(const Curvature& curvature) {
    bool any = false;
    for (const auto& row : curvature.stiffness) {
      for (const auto& entry : row) {
        any = any || *entry > 0.0;
      }
    }
    if (!any) {
      refuse(curvature.model.source,
             " = \"orthotropic\": expected curvature.stiffness = { yx = ..., ... } with an entry "
             "above 0");
    }
    for (const Located<double>& weight : {curvature.alpha, curvature.beta, curvature.gamma}) {
      if (*weight != 1.0) {
        refuse(weight.source, ": a weight of the isotropic model; the orthotropic one has stiffness = { xx ... zz }");
        break;
      }
    }
    check_basis(curvature.basis);
  }

  void check_basis(const Located<Mat3>& basis) {
    constexpr double TOLERANCE = 1e-6;
    const Mat3 product = basis->transpose() * *basis;
    for (Eigen::Index i = 0; i < 3; ++i) {
      const double length = std::sqrt(product(i, i));
      if (std::abs(length - 1.0) > TOLERANCE) {
        refuse(basis.source,
               fmt::format(": axis {} has length {:.9g}; expected 1 within {:g}", "xyz"[i], length, TOLERANCE));
        return;
      }
      const Eigen::Index j = (i + 1) % 3;
      if (std::abs(product(i, j)) > TOLERANCE) {
        refuse(basis.source, fmt::format(": axes {} and {} have the dot product {:.9g}; expected 0 within {:g}",
                                         "xyz"[i], "xyz"[j], product(i, j), TOLERANCE));
        return;
      }
    }
    if (basis->determinant() < 0.0) {
      refuse(basis.source, ": the axes are left-handed (determinant -1); turn one of them around");
    }
  }

  void check_region(const Region& region) {
    if (const auto* box = std::get_if<BoxRegion>(&region)) {
      for (Eigen::Index i = 0; i < 3; ++i) {
        if ((*box->min)[i] > (*box->max)[i]) {
          refuse(box->max.source, fmt::format(": along {} the box ends at {} before it begins at {}; swap min and max",
                                              "xyz"[i], (*box->max)[i], (*box->min)[i]));
          return;
        }
      }
    }
    if (const auto* cylinder = std::get_if<CylinderRegion>(&region); cylinder && *cylinder->from == *cylinder->to) {
      refuse(cylinder->to.source, ": both ends of the axis are the same point; a cylinder needs a length");
    }
  }

  void check_drive(const Drive& drive) {
    if (!*drive.positions && !*drive.microrotations) {
      refuse(drive.positions.source, " is empty: expected \"positions\", \"microrotations\" or both");
    }
    check_motion(drive.motion);
    const bool soft = *drive.method == DriveMethod::soft;
    if (soft && *drive.stiffness == 0.0 && *drive.turning_stiffness == 0.0) {
      refuse(below(drive.source, "stiffness"),
             " is missing: a soft drive needs stiffness (N/m), turning_stiffness (N m) or both");
    }
    for (const Located<double>& stiffness : {drive.stiffness, drive.turning_stiffness}) {
      if (!soft && *stiffness > 0.0) {
        refuse(stiffness.source, ": only soft drives have it; write method = \"soft\" or remove it");
      }
    }
    const Material* material = material_of(*drive.body);
    if (!*drive.positions && material != nullptr && !is_micropolar(*material->model)) {
      refuse(drive.microrotations.source,
             fmt::format(": body '{}' has no microrotations, so nothing would be driven; give it a micropolar model or "
                         "drive positions",
                         *drive.body));
    }
  }

  const Material* material_of(const std::string& body_name) const {
    const Body* body = m_shot.find_body(body_name);
    return body == nullptr ? nullptr : m_shot.find_material(*body->material);
  }

  void check_load(const Load& load) {
    const auto given = [](const auto& components) {
      return std::any_of(components.begin(), components.end(), [](const auto& entry) { return entry.has_value(); });
    };
    if (!given(load.force) && !given(load.torque)) {
      refuse(below(load.source, "force"), " is missing: give force = { x = ... }, torque = { x = ... } or both");
    }
    const Material* material = material_of(*load.body);
    if (given(load.torque) && material != nullptr && !is_micropolar(*material->model)) {
      refuse(below(load.source, "torque"),
             fmt::format(": body '{}' has no microrotations that a torque could turn; give it a micropolar model, or "
                         "use two forces",
                         *load.body));
    }
  }

  void need_body(const std::string& body, const Source& source) {
    if (body.empty()) {
      refuse(below(source, "body"), fmt::format(" is missing: the shot has {} bodies; name one", m_shot.bodies.size()));
    }
  }

  void check_measure(const Measure& measure) {
    need_body(*measure.body, measure.source);
    const bool along_axis = needs_axis(*measure.kind);
    const bool maybe_along_axis =
        along_axis || *measure.kind == MeasureKind::run_out || *measure.kind == MeasureKind::mean_alignment;
    if (*measure.kind == MeasureKind::fraction_outside && !measure.where) {
      refuse(below(measure.source, "where"), " is missing: the part of space that the particles are outside of");
    }
    if (along_axis && !measure.axis) {
      refuse(below(measure.source, "axis"), " is missing: this is measured along or about \"x\", \"y\" or \"z\"");
    }
    if (!maybe_along_axis && measure.axis) {
      refuse(measure.axis->source, ": this kind of measure has no axis; remove it");
    }
    const bool of_grains = *measure.kind == MeasureKind::grains_inside || *measure.kind == MeasureKind::grain_hover;
    const Body* body = m_shot.find_body(*measure.body);
    if (of_grains && body != nullptr && !body->particles.grains) {
      refuse(measure.kind.source, fmt::format(": body '{}' has no sub_particles to be measured", *measure.body));
    }
    if (of_grains && measure.where) {
      refuse(measure.source, ": all grains are measured; remove where");
    }
    if (measure.where) {
      check_region(*measure.where);
    }
  }

  void check_expectation(const Expectation& expectation) {
    if (!expectation.min && !expectation.max) {
      refuse(below(expectation.source, "min"), " is missing: give min, max or both; without them nothing is expected");
    }
    if (expectation.frame) {
      check_expected_frame(*expectation.frame);
    }
    if (*expectation.every_frame && expectation.ratio_to) {
      refuse(expectation.every_frame.source, " = true: ratios between wedges are of one frame; remove ratio_to");
    }
    if (expectation.min && expectation.max && **expectation.min > **expectation.max) {
      refuse(expectation.max->source,
             fmt::format(" = {}: expected at least min = {}", **expectation.max, **expectation.min));
    }
  }

  /// A frame that a run never comes to would never be judged. A range that the command line cuts says so as it runs.
  void check_expected_frame(const Located<std::int64_t>& frame) {
    const Located<FrameRange>& frames = m_shot.shot.frames;
    const bool cut = frames.source.origin == Origin::command_line && frame.source.origin != Origin::command_line;
    if (cut || m_diagnostics.any_under("shot") || (*frame >= frames->first() && *frame <= frames->last()))
      return;
    refuse(frame.source, fmt::format(" = {}: the shot has frames {} to {}; expected one of them, or longer shot.frames",
                                     *frame, frames->first(), frames->last()));
  }

  void check_settings() {
    const FemOptions& fem = m_shot.fem;
    if (fem.time_step && *fem.min_time_step > **fem.time_step && !m_diagnostics.any_under("fem")) {
      refuse(fem.min_time_step.source,
             fmt::format(" = {}: expected at most time_step = {} s", *fem.min_time_step, **fem.time_step));
    }
    if (*fem.rotation_update == RotationUpdate::exponential && *fem.integrator != Integrator::backward_euler) {
      refuse(
          fem.rotation_update.source,
          " = \"exponential\": only backward-euler feels it; bdf2 and sdirk2 count increments from where rotations are "
          "expected, so that both updates are the same to their order; remove it");
    }
    const Camera& camera = m_shot.render.camera;
    if (camera.position && camera.target && **camera.position == **camera.target) {
      refuse(camera.target->source, ": the camera stands where it looks; move target or position");
    }
    for (const HeatRange& range : m_shot.render.heat) {
      if (range.min && range.max && **range.min >= **range.max) {
        refuse(range.max->source, fmt::format(" = {}: expected more than min = {}", **range.max, **range.min));
      }
    }
  }

  const Shot& m_shot;
  Diagnostics& m_diagnostics;
};

} // namespace

void check_rules(const Shot& shot, Diagnostics& diagnostics) {
  Rules(shot, diagnostics).check();
}

} // namespace wry::shots
