#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/isa.h"
#include "sim/base/types.h"
#include "sim/geometry/tet_mesh.h"
#include "sim/scene/collider.h"
#include "sim/scene/motion.h"

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

/// How a body is cut into elements. All but tet4 have kernels for the physically linear micropolar model only.
enum class ElementKind {
  tet4,           ///< linear positions and rotations, four points
  tet4_one_point, ///< the same with one point, which leaves rotations that cost nothing (hourglass modes)
  tet10,          ///< quadratic positions, linear rotations
  plate3,         ///< triangles of a plate: linear positions and rotations
  plate6          ///< quadratic positions, linear rotations
};
bool is_plate(ElementKind kind);
/// Whether midpoints of edges carry positions.
bool is_quadratic(ElementKind kind);

/// What resists the bending of a plate beside its stretch (spec section 9).
enum class PlateBending {
  h3,  ///< h^3/12 (mu |sym K|^2 + mu_c |skew K|^2 + lambda' tr(K)^2), that of the thickness
  curv ///< h mu L_c^2/2 (alpha |sym K|^2 + beta |skew K|^2 + gamma tr(K)^2), that of the curvature energy
};

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
  PlateBending plate_bending = PlateBending::h3;
  std::optional<double> max_stretch; ///< of plates: principal stretches beyond are resisted steeply
  double mass_damping = 0.0;         ///< force per momentum [1/s]
  double stiffness_damping = 0.0;    ///< force per rate of the elastic forces [s]
};

/// A place inside a body at rest.
struct RestPlace {
  Vec3 position = Vec3::Zero();              ///< [m]
  Eigen::Index tet = -1;                     ///< of the body's mesh; -1: the element is none of its tets
  std::array<std::int32_t, 4> vertices = {}; ///< of the body's mesh: the corners of its element
  Vec4 weights = Vec4::Zero();               ///< of these vertices; plates do not use the last
};

/// Rest curvature Gamma0 in the material frame at a place and a time [1/m]; called from several threads at once.
using RestCurvature = std::function<Mat3(const RestPlace& place, double time)>;

/// Factors on the material's values, one per tet of the mesh; empty: 1.
struct MaterialFactors {
  std::vector<double> density, youngs_modulus, couple_modulus_ratio, length_scale;
};

struct FemBody {
  std::string name;
  /// Vertices, and tets unless it is a plate. Quadratic elements: corners first, then the midpoints of edges.
  std::shared_ptr<const geometry::TetMesh> mesh;
  FemMaterial material;
  ElementKind element = ElementKind::tet4;
  Triangles triangles;    ///< of a plate
  double thickness = 0.0; ///< of a plate [m]
  /// The ends of the edges whose midpoints are the last vertices of the mesh; empty for linear elements.
  std::vector<std::array<std::int32_t, 2>> edges;
  Vec3 initial_velocity = Vec3::Zero(); ///< [m/s]
  RestCurvature rest_curvature;         ///< empty: none
  bool rest_curvature_moves = true;     ///< whether it depends on the time
  MaterialFactors factors;
  /// Rest rotation R0 (spec §2), per vertex and per tet: the directors at rest, and the axes that curvature stiffness
  /// and rest curvature refer to. Empty: those of the world.
  std::vector<Vec4> vertex_rest_rotations;
  std::vector<Mat3> tet_rest_rotations;
};

/// The body with a vertex on the middle of each edge of its elements, and the quadratic kind of its element.
FemBody with_midpoints(FemBody body);

/// Triangles of the boundary of a body, or of a plate itself; the edges of quadratic elements have two parts each.
Triangles surface_triangles(const FemBody& body);

/// Nodes that are held where they rest.
struct FixedNodes {
  std::string name;
  int body = 0;
  std::vector<std::int32_t> nodes; ///< indices into the body's vertices
  bool hold_positions = true;
  bool hold_microrotations = true;               ///< only of micropolar bodies
  std::optional<double> until;                   ///< released after this time [s]
  std::array<bool, 3> axes = {true, true, true}; ///< of positions, along x, y, z
};

/// How a drive makes its nodes follow.
enum class DriveMethod {
  exact,   ///< their unknowns are given, not solved for
  penalty, ///< springs ten thousand times stiffer than the matter around a node
  soft,    ///< springs of a given stiffness
};

/// Nodes that move as a whole along a motion, from where they rest.
struct DrivenNodes {
  std::string name;
  int body = 0;
  std::vector<std::int32_t> nodes; ///< indices into the body's vertices
  scene::Motion motion;            ///< none: they are held where they rest
  bool drive_positions = true;
  bool drive_microrotations = true; ///< only of micropolar bodies
  /// Which components of the microrotations' increments, in the world, are given; of exact drives.
  std::array<bool, 3> driven_turns = {true, true, true};
  DriveMethod method = DriveMethod::exact;
  double stiffness = 0.0;         ///< of all soft springs together, shared out by mass [N/m]
  double turning_stiffness = 0.0; ///< the same for turns [N m]
  std::optional<double> until;    ///< released after this time [s]
};

/// Forces and torques that act on nodes, shared out.
struct FemLoad {
  std::string name;
  int body = 0;
  std::vector<std::int32_t> nodes;         ///< indices into the body's vertices
  std::vector<double> shares;              ///< per node: of a volume [m^3], an area [m^2], or of the whole
  std::function<Vec3(double time)> force;  ///< per share [N]; empty: none
  std::function<Vec3(double time)> torque; ///< per share [N m], on the microrotations; empty: none
};

/// How rotations at quadrature points come from those of the nodes.
enum class PointRotations {
  interpolated_velocity, ///< their own history, turned by the interpolated increments: the paper's way
  rotation_vectors,      ///< mean of the rotation vectors
  quaternion_blend,      ///< normalised mean of the quaternions
  spherical_average,     ///< Buss and Fillmore's mean on the sphere
};

/// What frames hold besides the state: costs nothing unless a measure or a view asks.
struct FemOutputs {
  bool reactions = false;        ///< force and torque that holds and drives exert on each node
  bool point_rotations = false;  ///< microrotations of the quadrature points
  bool curvature_energy = false; ///< its density, beside that of the whole energy
};

enum class Integrator {
  backward_euler, ///< first order, damps what a step cannot resolve
  bdf2,           ///< second order; remembers the step before
  sdirk2,         ///< second order in two solves per step, L-stable
};

/// How an angular velocity turns a rotation over a step.
enum class RotationUpdate {
  cayley,      ///< eq 26 of the paper: q + dt/2 omega q, made unit; falls short by |dt omega|^3/12
  exponential, ///< eq 25: exactly by |dt omega|, at nodes; quadrature points interpolate what nodes turn by
};

enum class LinearSolver { automatic, pcg, cholesky, stale_cholesky };

struct FemSettings {
  /// After every so many steps the rotations of quadrature points are made anew from those of the nodes; 0: never.
  /// `interpolated_velocity` never is.
  int reset_every = 0;
  PointRotations point_rotations = PointRotations::interpolated_velocity;
  Integrator integrator = Integrator::backward_euler;
  RotationUpdate rotation_update = RotationUpdate::cayley; ///< exponential: of backward Euler only
  double max_time_step = 0.01;                             ///< [s]; the step is cut on failure and grows back
  double min_time_step = 1e-7;                             ///< the floor below which the simulation stops with an error
  /// Newton stops at |gradient of the incremental potential| below this [N s, N m s].
  double newton_tolerance = 1e-8;
  int max_newton_iterations = 250;
  LinearSolver linear_solver = LinearSolver::automatic;
  double linear_tolerance = 0.0;           ///< relative; 0: inexact Newton chooses
  std::optional<double> contact_distance;  ///< d-hat [m]; absent: from the scene
  std::optional<double> contact_stiffness; ///< kappa [N/m]; absent: from the scene
  double friction_velocity = 1e-3;         ///< slip speed below which friction is smoothed [m/s]
};

/// Coulomb's coefficients: at rest, and while sliding.
struct Friction {
  double at_rest = 0.0;
  double sliding = 0.0;
};

/// Friction of two materials, by name, in either order.
struct MaterialPair {
  std::string first, second;
  Friction friction;
};

/// Contact of bodies with each other and each with itself.
struct ContactOptions {
  bool between_bodies = true;
  bool within_bodies = true;
  Friction friction; ///< of materials that have no pair of their own
  std::vector<MaterialPair> pairs;
};

/// Everything the solids of a scene need, immutable.
struct FemPlan {
  std::vector<FemBody> bodies;
  std::vector<FixedNodes> fixed;
  std::vector<DrivenNodes> driven;
  std::vector<FemLoad> loads;
  FemOutputs outputs;
  std::vector<scene::PlaneCollider> planes; ///< that stand still
  std::vector<scene::Collider> obstacles;   ///< of every other shape, and what moves
  std::optional<ContactOptions> contact;    ///< absent: bodies feel planes and obstacles only
  Vec3 gravity{0.0, -9.81, 0.0};            ///< [m/s^2]
  FemSettings settings;
};

} // namespace wry::fem
