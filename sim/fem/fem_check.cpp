#include <array>
#include <cmath>

#include <Eigen/LU>

#include "sim/fem/fem_scene.h"

namespace wry::fem {

namespace {

struct Range {
  const char* key;
  double value;
  double least; ///< exclusive
  double most;  ///< exclusive
};

Status check_material(const FemBody& body) {
  const FemMaterial& m = body.material;
  const double infinity = std::numeric_limits<double>::infinity();
  const std::array ranges = {
      Range{"density", m.density, 0.0, infinity},
      Range{"youngs_modulus", m.youngs_modulus, 0.0, infinity},
      Range{"poisson_ratio", m.poisson_ratio, -1.0, 0.5},
  };
  for (const Range& range : ranges) {
    if (!(range.value > range.least && range.value < range.most))
      return make_error(ErrorCode::bad_input, "body '{}', material '{}': {} = {}, but it must lie between {} and {}",
                        body.name, m.name, range.key, range.value, range.least, range.most);
  }
  const bool curvature = m.curvature != CurvatureModel::none && m.length_scale != 0.0;
  if (!is_micropolar(m.model))
    return {};
  for (const double value : {m.couple_modulus_ratio, m.length_scale, m.rotary_inertia}) {
    if (!(value >= 0.0) || !std::isfinite(value))
      return make_error(
          ErrorCode::bad_input,
          "body '{}', material '{}': couple_modulus_ratio, length_scale and rotary_inertia must be finite "
          "and not negative, found {}",
          body.name, m.name, value);
  }
  if (!m.curvature_stiffness.allFinite() || !m.curvature_basis.allFinite() ||
      !std::isfinite(m.alpha + m.beta + m.gamma))
    return make_error(ErrorCode::bad_input, "body '{}', material '{}': a curvature modulus is not a finite number",
                      body.name, m.name);
  if (body.element == ElementKind::tet4_one_point && !curvature && m.rotary_inertia == 0.0)
    return make_error(
        ErrorCode::bad_input,
        "body '{}', material '{}': one quadrature point leaves microrotations that nothing resists, so the "
        "system is singular; give rotary_inertia or length_scale a positive value, or take quadrature = "
        "\"full\"",
        body.name, m.name);
  if (m.couple_modulus_ratio == 0.0 && !curvature && m.rotary_inertia == 0.0)
    return make_error(
        ErrorCode::bad_input,
        "body '{}', material '{}': nothing resists microrotations (couple_modulus_ratio = 0, no curvature "
        "energy, rotary_inertia = 0), so the system is singular; give one of them a positive value, or "
        "use a model without microrotations",
        body.name, m.name);
  return {};
}

Status check_plate(const FemBody& body) {
  if (!(body.thickness > 0.0) || !std::isfinite(body.thickness))
    return make_error(ErrorCode::bad_input, "body '{}': a plate needs a thickness above 0, found {}", body.name,
                      body.thickness);
  if (body.material.max_stretch && !(*body.material.max_stretch >= 1.0))
    return make_error(ErrorCode::bad_input, "body '{}', material '{}': max_stretch = {}, but it must be at least 1",
                      body.name, body.material.name, *body.material.max_stretch);
  for (Eigen::Index i = 0; i < body.triangles.size(); ++i) {
    if (body.triangles.data()[i] < 0 || body.triangles.data()[i] >= body.mesh->vertices.rows())
      return make_error(ErrorCode::bad_input, "body '{}': triangle {} refers to vertex {} of {}", body.name, i / 3,
                        body.triangles.data()[i], body.mesh->vertices.rows());
  }
  return {};
}

Status check_mesh(const FemBody& body) {
  if (!body.mesh || (is_plate(body.element) ? body.triangles.rows() : body.mesh->tets.rows()) == 0)
    return make_error(ErrorCode::bad_input, "body '{}' has no {}", body.name,
                      is_plate(body.element) ? "triangles" : "tets");
  const geometry::TetMesh& mesh = *body.mesh;
  for (Eigen::Index vertex = 0; vertex < mesh.vertices.rows(); ++vertex) {
    if (!mesh.vertices.row(vertex).allFinite())
      return make_error(ErrorCode::bad_input, "body '{}': vertex {} is at ({}, {}, {}), which is not finite", body.name,
                        vertex, mesh.vertices(vertex, 0), mesh.vertices(vertex, 1), mesh.vertices(vertex, 2));
  }
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    for (int k = 0; k < 4; ++k) {
      if (mesh.tets(tet, k) < 0 || mesh.tets(tet, k) >= mesh.vertices.rows())
        return make_error(ErrorCode::bad_input, "body '{}': tet {} refers to vertex {} of {}", body.name, tet,
                          mesh.tets(tet, k), mesh.vertices.rows());
    }
    const Vec3 origin = mesh.vertices.row(mesh.tets(tet, 0));
    Mat3 edges;
    for (int k = 0; k < 3; ++k)
      edges.col(k) = mesh.vertices.row(mesh.tets(tet, k + 1)).transpose() - origin;
    const double volume = edges.determinant() / 6.0;
    const double extent = edges.cwiseAbs().maxCoeff();
    // Below this the shape gradients are round-off and so would be everything computed from them.
    if (!(volume > 1e-13 * extent * extent * extent))
      return make_error(
          ErrorCode::bad_input,
          "body '{}': tet {} (vertices {} {} {} {}) has the volume {:.3g} m^3 at an extent of {:.3g} m: it is "
          "flat, inverted or repeats a vertex; repair the mesh or mesh it anew",
          body.name, tet, mesh.tets(tet, 0), mesh.tets(tet, 1), mesh.tets(tet, 2), mesh.tets(tet, 3), volume, extent);
  }
  if (!body.initial_velocity.allFinite())
    return make_error(ErrorCode::bad_input, "body '{}': the initial velocity is not finite", body.name);
  return is_plate(body.element) ? check_plate(body) : Status();
}

Status check_fixed(const FemPlan& plan, const FixedNodes& fixed) {
  if (fixed.body < 0 || fixed.body >= static_cast<int>(plan.bodies.size()))
    return make_error(ErrorCode::bad_input, "fixed '{}' names body {} of {}", fixed.name, fixed.body,
                      plan.bodies.size());
  const Eigen::Index vertices = plan.bodies[fixed.body].mesh->vertices.rows();
  for (const std::int32_t node : fixed.nodes) {
    if (node < 0 || node >= vertices)
      return make_error(ErrorCode::bad_input, "fixed '{}': vertex {} of body '{}', which has {}", fixed.name, node,
                        plan.bodies[fixed.body].name, vertices);
  }
  return {};
}

Status check_settings(const FemPlan& plan) {
  const FemSettings& s = plan.settings;
  const double infinity = std::numeric_limits<double>::infinity();
  const std::array ranges = {
      Range{"fem.max_time_step", s.max_time_step, 0.0, infinity},
      Range{"fem.min_time_step", s.min_time_step, 0.0, infinity},
      Range{"fem.newton_tolerance", s.newton_tolerance, 0.0, infinity},
      Range{"fem.friction_velocity", s.friction_velocity, 0.0, infinity},
      Range{"fem.contact_distance", s.contact_distance.value_or(1.0), 0.0, infinity},
      Range{"fem.contact_stiffness", s.contact_stiffness.value_or(1.0), 0.0, infinity},
      Range{"fem.linear_tolerance", s.linear_tolerance, -1e-300, 1.0},
      Range{"fem.max_newton_iterations", static_cast<double>(s.max_newton_iterations), 0.0, infinity},
  };
  for (const Range& range : ranges) {
    if (!(range.value > range.least && range.value < range.most))
      return make_error(ErrorCode::bad_input, "{} = {}, but it must lie between {} and {}", range.key, range.value,
                        range.least, range.most);
  }
  if (s.rotation_update == RotationUpdate::exponential && s.integrator != Integrator::backward_euler)
    return make_error(ErrorCode::bad_input,
                      "fem.rotation_update = \"exponential\" goes with backward-euler only: bdf2 and sdirk2 count "
                      "increments from where rotations are expected, so that both updates are the same to their order");
  if (!plan.gravity.allFinite())
    return make_error(ErrorCode::bad_input, "gravity is not finite");
  for (const scene::PlaneCollider& plane : plan.planes) {
    if (!plane.point.allFinite() || !plane.normal.allFinite() || std::abs(plane.normal.norm() - 1.0) > 1e-6 ||
        !(plane.friction >= 0.0) || !std::isfinite(plane.friction))
      return make_error(ErrorCode::bad_input,
                        "plane '{}': point, unit normal and friction >= 0 must be finite numbers, found a normal of "
                        "length {} and friction {}",
                        plane.name, plane.normal.norm(), plane.friction);
  }
  return {};
}

} // namespace

Status check_plan(const FemPlan& plan) {
  if (plan.bodies.empty())
    return make_error(ErrorCode::bad_input, "there is no solid body to simulate");
  if (Status status = check_settings(plan); !status)
    return status;
  for (const FemBody& body : plan.bodies) {
    if (Status status = check_mesh(body); !status)
      return status;
    if (Status status = check_material(body); !status)
      return status;
  }
  for (const FixedNodes& fixed : plan.fixed) {
    if (Status status = check_fixed(plan, fixed); !status)
      return status;
  }
  return {};
}

} // namespace wry::fem
