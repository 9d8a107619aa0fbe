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

  void check_body(const Body& body) {
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

  void check_material(const Material& material) {
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

  void need_body(const std::string& body, const Source& source) {
    if (body.empty()) {
      refuse(below(source, "body"), fmt::format(" is missing: the shot has {} bodies; name one", m_shot.bodies.size()));
    }
  }

  void check_measure(const Measure& measure) {
    need_body(*measure.body, measure.source);
    const bool along_axis = *measure.kind == MeasureKind::extent || *measure.kind == MeasureKind::centre;
    if (along_axis && !measure.axis) {
      refuse(below(measure.source, "axis"), " is missing: extent and centre are measured along \"x\", \"y\" or \"z\"");
    }
    if (!along_axis && measure.axis) {
      refuse(measure.axis->source, ": only extent and centre have an axis; remove it");
    }
    if (measure.where) {
      check_region(*measure.where);
    }
  }

  void check_expectation(const Expectation& expectation) {
    if (!expectation.min && !expectation.max) {
      refuse(below(expectation.source, "min"), " is missing: give min, max or both; without them nothing is expected");
    }
    if (expectation.min && expectation.max && **expectation.min > **expectation.max) {
      refuse(expectation.max->source,
             fmt::format(" = {}: expected at least min = {}", **expectation.max, **expectation.min));
    }
  }

  void check_settings() {
    const FemOptions& fem = m_shot.fem;
    if (fem.time_step && *fem.min_time_step > **fem.time_step && !m_diagnostics.any_under("fem")) {
      refuse(fem.min_time_step.source,
             fmt::format(" = {}: expected at most time_step = {} s", *fem.min_time_step, **fem.time_step));
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
