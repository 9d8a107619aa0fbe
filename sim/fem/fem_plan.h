#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/isa.h"
#include "sim/base/types.h"
#include "sim/geometry/tet_mesh.h"
#include "sim/scene/collider.h"

namespace wry::fem {

/// Strain energies of a solid; spec names in brackets.
enum class ElasticModel {
  neo_hookean,            ///< mu/2 (I_C - 3) - mu ln J + lambda/2 ln^2 J  [nh]
  neo_hookean_eq16,       ///< the paper's eq 16 without couple modulus  [nh16]
  stvk,                   ///< St. Venant-Kirchhoff  [stvk]
  corotated,              ///< mu |F - R|^2 + lambda/2 tr(R^T F - I)^2  [corot]
  micropolar,             ///< physically linear, eq 11  [mp_lin]
  micropolar_det,         ///< eq 11 with the volume term of det F  [mp_det]
  micropolar_neo_hookean, ///< eq 16  [mp_nh]
};

/// Whether a model carries microrotations (6 dofs per node), or displacements only (3).
bool is_micropolar(ElasticModel model);

enum class CurvatureModel { none, isotropic, orthotropic };

/// A material as a body's elements need it.
struct FemMaterial {
  std::string name;
  ElasticModel model = ElasticModel::neo_hookean;
  double density = 1000.0;     ///< [kg/m^3]
  double youngs_modulus = 1e5; ///< [Pa]
  double poisson_ratio = 0.3;
  double couple_modulus_ratio = 1.0; ///< mu_c / mu
  double length_scale = 0.0;         ///< L_c [m]
  CurvatureModel curvature = CurvatureModel::none;
  double alpha = 1.0, beta = 1.0, gamma = 1.0; ///< isotropic curvature, eq 12
  Mat3 curvature_stiffness = Mat3::Zero();     ///< orthotropic C_ij, row: axis, column: direction moved along
  Mat3 curvature_basis = Mat3::Identity();     ///< columns: material axes
  double rotary_inertia = 0.0;                 ///< j0 [kg/m]
};

/// Rest curvature Gamma0 in the material frame at a rest position and a time [1/m].
using RestCurvature = std::function<Mat3(const Vec3& rest_position, double time)>;

struct FemBody {
  std::string name;
  std::shared_ptr<const geometry::TetMesh> mesh;
  FemMaterial material;
  Vec3 initial_velocity = Vec3::Zero(); ///< [m/s]
  RestCurvature rest_curvature;         ///< empty: none
};

/// Nodes that are held where they rest.
struct FixedNodes {
  std::string name;
  int body = 0;
  std::vector<std::int32_t> nodes; ///< indices into the body's vertices
  bool hold_positions = true;
  bool hold_microrotations = true; ///< only of micropolar bodies
  std::optional<double> until;     ///< released after this time [s]
};

enum class LinearSolver { automatic, pcg, cholesky, stale_cholesky };

struct FemSettings {
  double max_time_step = 0.01; ///< [s]; the step is cut on failure and grows back
  double min_time_step = 1e-7; ///< the floor below which the simulation stops with an error
  /// Newton stops at |gradient of the incremental potential| below this [N s, N m s].
  double newton_tolerance = 1e-8;
  int max_newton_iterations = 60;
  LinearSolver linear_solver = LinearSolver::automatic;
  double linear_tolerance = 0.0;           ///< relative; 0: inexact Newton chooses
  std::optional<double> contact_distance;  ///< d-hat [m]; absent: from the scene
  std::optional<double> contact_stiffness; ///< kappa [N/m]; absent: from the scene
  double friction_velocity = 1e-3;         ///< slip speed below which friction is smoothed [m/s]
};

/// Everything the solids of a scene need, immutable.
struct FemPlan {
  std::vector<FemBody> bodies;
  std::vector<FixedNodes> fixed;
  std::vector<scene::PlaneCollider> planes;
  Vec3 gravity{0.0, -9.81, 0.0}; ///< [m/s^2]
  FemSettings settings;
};

} // namespace wry::fem
