#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "shots/frame_range.h"
#include "shots/shot_mpm.h"
#include "shots/source.h"
#include "sim/base/types.h"

/// A Shot is what was asked: every key of the shot file with its value and its source, checked key by key (type, range,
/// names that must exist), nothing derived and nothing looked up on disk. SI units. Immutable by use: it is made by
/// load_shot (shots/load.h) and passed on as const.
///
/// Optional keys without a default are std::optional<Located<T>>; all other keys hold their default with
/// Origin::standard. Paths are absolute or relative to the folder of the process, ready to be opened.
namespace wry::shots {

struct ResolvedTree;

enum class Axis { x, y, z };

/// [shot]
struct ShotSettings {
  Located<std::string> name;  ///< default: the file's name without .toml
  Located<FrameRange> frames; ///< frame f is t = (f - first) / fps
  Located<double> fps;        ///< [1/s]
  Located<Axis> up;
  Located<Vec3> gravity; ///< [m/s^2]; default 9.81 against up
  Located<std::int64_t> seed;
};

// Primitives stand around the origin, before `size`, `scale`, `rotate` and `translate` act.

/// mesh = "...": an artist mesh, or a Gmsh tet mesh when it ends with .msh.
struct MeshShape {
  Located<std::string> path;
  bool is_tet_mesh = false;
};
struct BoxShape {
  Located<Vec3> size; ///< [m]
};
struct SphereShape {
  Located<double> radius; ///< [m]
};
/// Along y.
struct CylinderShape {
  Located<double> radius, height; ///< [m]
};
/// A bar along x: u runs along it.
struct RodShape {
  Located<double> length, width, height; ///< [m] along x, z and y; height defaults to width
};
/// In the x-z plane, its normal along y: u along x, v along z.
struct SheetShape {
  Located<double> width, depth, thickness; ///< [m] along x, z and y
};
/// Around y.
struct TorusShape {
  Located<double> radius, tube_radius; ///< [m]
};
using Shape = std::variant<MeshShape, BoxShape, SphereShape, CylinderShape, RodShape, SheetShape, TorusShape>;

/// size = { height = 1.0 }: scaled evenly until this extent has this length. Height is along the shot's up axis, width
/// along x (y when up is x), depth along the remaining one; max is the largest of the three.
enum class SizeMeasure { height, width, depth, max };
struct Size {
  SizeMeasure measure = SizeMeasure::height;
  Located<double> length; ///< [m]
};

struct Rotation {
  Located<Vec3> axis; ///< not zero, not normalised
  Located<double> degrees;
};

struct Shell {
  Located<double> thickness; ///< [m]
  Located<std::int64_t> layers;
};

/// How the cells of structured meshes are cut into tets.
enum class CellSplit { symmetric, kuhn };

/// How a shape or mesh file comes into the shot's world.
struct Placed {
  std::optional<Size> size;        ///< excludes scale
  Located<double> scale;           ///< after units
  Located<double> metres_per_unit; ///< from `units`: of mesh files
  std::optional<Located<Axis>> up; ///< up axis of the mesh file; absent: as the shot's
  std::vector<Rotation> rotate;    ///< applied in order, about the origin, after size and scale
  Located<Vec3> translate;         ///< [m], last
};

/// Kinds of elements: linear, or with quadratic positions; automatic is linear for tets and quadratic for plates.
enum class Element { automatic, tet4, tet10, tri3, tri6 };
enum class Quadrature { full, one_point };

/// [[body]]
/// What of a body is drawn: its shape (an artist's mesh, a ball, a ring) carried by the elements, or their own faces.
enum class DrawnAs { automatic, shape, elements };

struct Body : Placed {
  Source source; ///< of the table
  Located<std::string> name;
  Shape shape;
  std::optional<Shell> shell;                ///< hollow it; absent: solid
  std::optional<Located<double>> resolution; ///< target edge [m]; required unless cells are given or it is a tet mesh
  std::optional<Located<std::array<std::int64_t, 3>>> cells; ///< along x, y, z; of box, rod, sheet, cylinder
  Located<CellSplit> split;
  Located<Element> element;
  Located<Quadrature> quadrature;
  Located<std::string> material;            ///< the name of a [material.X] that exists
  std::optional<Located<std::string>> look; ///< a [look.X] or a built-in look; absent: a default look
  Located<DrawnAs> draw;
  Located<Vec3> velocity; ///< initial [m/s]
  ParticleBody particles; ///< when the material's model is mpm; a region takes the place of shape
  /// Rotation vector of the directors at rest [degrees]; nullopt: 0.
  std::array<std::optional<Located<Expression>>, 3> rest_rotation;
};

enum class MaterialModel {
  neo_hookean,
  neo_hookean_eq16,
  stvk,
  corotated,
  micropolar,
  micropolar_det,
  micropolar_neo_hookean,
  plate,
  mpm ///< the material point method: see Material::matter
};
/// Whether the model carries microrotations.
bool is_micropolar(MaterialModel model);

enum class CurvatureModel { isotropic, orthotropic };
/// What resists the bending of a plate: its thickness, or the energy of curvature.
enum class PlateBending { h3, curv };
/// Whether microrotations are unknowns, or minimised away where theory allows.
enum class Microrotation { automatic, solved, condensed };
struct Curvature {
  Located<CurvatureModel> model;
  Located<double> alpha, beta, gamma;                      ///< isotropic
  std::array<std::array<Located<double>, 3>, 3> stiffness; ///< orthotropic C_ij: row axis, column direction; default 0
  Located<Mat3> basis;                                     ///< columns: material axes; orthonormal, right-handed
};

/// [material.X]
struct Material {
  Source source;
  Located<std::string> name;
  std::optional<Located<std::string>> preset;
  Located<MaterialModel> model;
  Located<double> density;                    ///< [kg/m^3]
  Located<double> youngs_modulus;             ///< [Pa]
  Located<double> poisson_ratio;              ///< in (-1, 0.5)
  Located<double> couple_modulus_ratio;       ///< mu_c / mu
  Located<double> length_scale;               ///< L_c [m]; 0: no curvature energy
  Located<double> rotary_inertia;             ///< j0 [kg/m]
  std::optional<Located<double>> thickness;   ///< of plates [m]; absent: that of the sheet
  Located<PlateBending> bending;              ///< of plates
  std::optional<Located<double>> max_stretch; ///< of plates
  Located<Microrotation> microrotation;
  Located<double> mass_damping;      ///< [1/s]
  Located<double> stiffness_damping; ///< [s]
  /// Factors on the values above, as formulas; nullopt: 1.
  struct Vary {
    std::optional<Located<Expression>> density, youngs_modulus, couple_modulus_ratio, length_scale;
  } vary;
  Curvature curvature;
  Matter matter; ///< of mpm
  /// Gamma0 [1/m], [row: axis][column: direction]; nullopt: 0. Formulas see t, X, Y, Z, u, v and mesh attributes.
  std::array<std::array<std::optional<Located<Expression>>, 3>, 3> rest_curvature;
  bool has_rest_curvature() const;
};

// Where nodes are picked: rest positions in the shot's world, after the body's placement [m].
struct BoxRegion {
  Located<Vec3> min, max;
};
struct SphereRegion {
  Located<Vec3> centre;
  Located<double> radius;
};
struct CylinderRegion {
  Located<Vec3> from, to; ///< ends of the axis
  Located<double> radius;
};
/// Nodes where the formula of X, Y, Z, u, v is not zero.
struct ExpressionRegion {
  Located<Expression> expression;
};
/// Nodes where this mesh attribute is above 0.5.
struct AttributeRegion {
  Located<std::string> attribute;
};
using Region = std::variant<BoxRegion, SphereRegion, CylinderRegion, ExpressionRegion, AttributeRegion>;

/// [[fixed]]: nodes held where they rest.
struct Fixed {
  Source source;
  Located<std::string> name;
  Located<std::string> body; ///< the name of a body that exists
  Region where;
  std::optional<Located<double>> until;              ///< released after this time [s]
  Located<bool> hold_positions, hold_microrotations; ///< from hold = ["positions", "microrotations"]
};

/// The free side of a plane is where the normal points.
struct PlaneShape {
  Located<Vec3> point;  ///< [m]
  Located<Vec3> normal; ///< not zero, not normalised
};
/// Around the origin before it is placed; with open sides only its walls.
struct OpenBoxShape {
  Located<Vec3> size;                     ///< [m]
  std::vector<Located<std::string>> open; ///< "-x", "+x", ...
  std::optional<Located<double>> wall;    ///< [m]; there when a side is open
};
/// mesh = "...", or what hangs from one of its nodes.
struct ColliderMeshShape {
  Located<std::string> path;
  std::optional<Located<std::string>> node;
  Located<double> thickness; ///< of an open mesh [m]
  /// The mesh over time: a PC2 point cache, or numbered meshes ("wave.####.obj").
  std::optional<Located<std::string>> sequence;
};
using ColliderShape = std::variant<PlaneShape, OpenBoxShape, SphereShape, CylinderShape, ColliderMeshShape>;

/// keys = [{ ... }, ...]: where something that moves as a whole is at a time, relative to where it rests. What a key
/// leaves out is as in the key before it, or zero.
struct MotionKey {
  Source source;
  Located<double> time;          ///< [s]
  Vec3 translate = Vec3::Zero(); ///< [m]
  Vec3 axis = Vec3::UnitY();     ///< not normalised
  double degrees = 0.0;
};
enum class Ease { linear, smooth };
/// From which animation a collider takes its motion.
enum class MotionFrom { keys, file };
struct Motion {
  Located<MotionFrom> from;
  std::vector<MotionKey> keys;
  Located<Vec3> pivot; ///< [m]
  Located<Ease> ease;
};

enum class DriveMethod { exact, penalty, soft };

/// [[drive]]: nodes moved as a whole from where they rest.
struct Drive {
  Source source;
  Located<std::string> name;
  Located<std::string> body; ///< the name of a body that exists
  Region where;
  Located<bool> positions, microrotations;      ///< from drive = ["positions", "microrotations"]
  Motion motion;                                ///< none when there are no keys
  std::optional<Located<std::string>> collider; ///< the name of a collider that exists, in place of keys
  Located<DriveMethod> method;
  Located<double> stiffness;            ///< [N/m]
  Located<double> turning_stiffness;    ///< [N m]
  std::optional<Located<double>> until; ///< released after this time [s]
};

enum class LoadPer { volume, area, whole };

/// [[load]]: forces and torques; nullopt: 0.
struct Load {
  Source source;
  Located<std::string> name;
  Located<std::string> body;   ///< the name of a body that exists
  std::optional<Region> where; ///< absent: all nodes
  Located<LoadPer> per;
  std::array<std::optional<Located<Expression>>, 3> force, torque;
};

enum class ColliderContact { separate, slip, sticky };

/// [[collider]]
struct Collider : Placed {
  Source source;
  Located<std::string> name;
  ColliderShape shape;
  Located<double> friction;
  Located<ColliderContact> contact;
  Motion motion;
  std::optional<Located<std::string>> look; ///< absent: a default look
  Located<bool> show;
};

/// [look.X]
struct Look {
  Source source;
  Located<std::string> name;
  Located<Vec3> colour;                     ///< linear or sRGB is said by the schema: sRGB, 0..1
  Located<double> roughness;                ///< 0..1
  Located<double> metallic;                 ///< 0..1
  Located<double> specular;                 ///< reflectance at normal incidence of non-metals, 0..0.2
  Located<double> wrap;                     ///< 0..1: light that wraps around soft matter
  std::optional<Located<std::string>> like; ///< a built-in look that keys not given are taken from
  std::optional<Located<Vec3>> scatter;     ///< sRGB
  Located<double> clearcoat, clearcoat_roughness;
  Located<double> transparency;
  Located<double> colour_variation, size_variation; ///< from grain to grain
  Located<bool> own_materials;                      ///< those of the mesh file
};

enum class Integrator { backward_euler, bdf2, sdirk2 };
/// How an angular velocity turns a microrotation over a step.
enum class RotationUpdate { cayley, exponential };
/// How rotations at quadrature points come from those of the nodes.
enum class PointRotations { velocity, rotation_vectors, quaternion_blend, spherical };
enum class LinearSolver { automatic, pcg, cholesky, stale_cholesky };

/// [fem]; nullopt stands for "auto".
struct FemOptions {
  Source source;
  Located<Integrator> integrator;
  std::optional<Located<double>> time_step; ///< [s]
  Located<double> min_time_step;            ///< [s]
  Located<double> newton_tolerance;         ///< [N s]
  Located<std::int64_t> max_newton_iterations;
  Located<LinearSolver> linear_solver;
  std::optional<Located<double>> linear_tolerance;  ///< relative
  std::optional<Located<double>> contact_distance;  ///< d-hat [m]
  std::optional<Located<double>> contact_stiffness; ///< [N/m]
  Located<double> friction_velocity;                ///< [m/s]
  Located<RotationUpdate> rotation_update;
  Located<PointRotations> point_rotations;
  Located<std::int64_t> reset_every;      ///< [steps]
  Located<std::int64_t> checkpoint_every; ///< [frames]; 0: only the last ones
  Located<std::int64_t> keep;             ///< last checkpoints kept
};

/// Friction at rest and while sliding.
struct FrictionOptions {
  Located<double> friction;
  std::optional<Located<double>> sliding_friction; ///< absent: as at rest
};

/// [contact.pair.X]
struct ContactPairOptions {
  Located<std::string> first, second; ///< names of materials that exist
  FrictionOptions friction;
};

/// [contact]
struct ContactOptions {
  Source source;
  Located<bool> between, within;
  FrictionOptions friction;
  std::vector<ContactPairOptions> pairs;
};

enum class ViewKind { beauty, clay, wire, heat, directors, fibres, contacts };
/// beauty, clay, wire, a heat map, or signs of what is inside: small frames, fibres, contact points.
struct View {
  ViewKind kind = ViewKind::beauty;
  std::string channel; ///< of heat views: "heat.speed" -> "speed"
  std::string name;    ///< as asked: "heat.speed"
};

struct CameraKey {
  Source source;
  Located<std::int64_t> frame;
  Located<Vec3> position;              ///< [m]
  std::optional<Located<Vec3>> target; ///< [m]
  std::optional<Located<double>> lens; ///< [mm]
};

struct Camera {
  Source source;
  std::optional<Located<Vec3>> position; ///< [m]; absent: on an orbit around the target, framed to the bounds
  std::optional<Located<Vec3>> target;   ///< [m]; absent: the middle of the sequence's bounds
  Located<double> azimuth_deg;           ///< about up; 0: in front (+z when up is y, or x)
  Located<double> elevation_deg;
  std::optional<Located<double>> distance;     ///< from the target [m]; absent: so that everything fits
  Located<double> lens;                        ///< focal length [mm] on a 36 mm wide film
  Located<double> margin;                      ///< part of the picture left free around the subject
  std::optional<Located<std::string>> look_at; ///< the name of a body that exists
  Located<double> orbit_turns;                 ///< over the sequence
  std::vector<CameraKey> keys;                 ///< in the order of the file
  std::optional<Located<std::string>> file, node;
};

enum class LightRig { studio, day, image };
struct Lights {
  Source source;
  Located<LightRig> rig;
  std::optional<Located<std::string>> image;
  Located<double> turn_deg, stops;
  std::optional<Located<std::string>> turn_with; ///< "camera" or "world"
  Located<bool> show_image;
};

struct DepthOfField {
  Source source;
  Located<double> f_stop;
  std::optional<Located<double>> focus; ///< [m]; absent: the subject
};

struct Ground {
  Located<bool> show;
  std::optional<Located<double>> height; ///< along up [m]; absent: the first plane collider, or the lowest point
  Located<Vec3> colour;                  ///< sRGB
  Located<bool> catch_shadow;            ///< only its shadow is drawn, as alpha
};

struct Turntable {
  Located<std::int64_t> frames;               ///< pictures of one turn
  std::optional<Located<std::int64_t>> frame; ///< the frame that turns; absent: the last
  Located<bool> moving;                       ///< the sequence plays while it turns
};

/// The two ends of a heat map's colour bar; absent ends come from the whole sequence.
struct HeatRange {
  Source source;
  std::string channel;
  std::optional<Located<double>> min, max;
};

/// [render]
struct RenderOptions {
  Source source;
  Located<std::array<std::int64_t, 2>> size; ///< width, height [pixels]
  Located<std::int64_t> samples;             ///< jittered sub-frames
  std::vector<Located<View>> views;
  Camera camera;
  Located<double> exposure; ///< [stops]
  Ground ground;
  Located<Vec3> background; ///< sRGB
  Located<bool> slate;
  Located<bool> shadows;
  Lights lights;
  Located<double> motion_blur; ///< open time of the shutter as a part of a frame
  std::optional<DepthOfField> depth_of_field;
  Located<bool> filmic;                  ///< else the sRGB curve alone
  Located<std::int64_t> bits;            ///< 8 or 16
  Located<bool> alpha;                   ///< the background is left clear
  std::vector<Located<std::string>> exr; ///< layers: colour, Z, N, velocity, id; empty: no such file
  Located<bool> contact_sheet;
  Turntable turntable;
  std::vector<HeatRange> heat;
};

enum class MeasureKind {
  height,
  extent,
  lowest,
  centre,
  volume,
  speed,
  kinetic_energy,
  strain_energy,
  run_out,
  front_position,
  pile_height,
  repose_angle,
  fraction_outside,
  mean_alignment,
  second_moment,
  largest_fragment,
  grains_inside,
  grain_hover,
  curvature_energy,
  bound_low,
  bound_high,
  tip_position,
  momentum,
  angular_momentum,
  reaction_force,
  reaction_torque,
  element_twist_max,
  rotation_distance,
  curvature_error,
  rotation_interpolation_error,
  curve_radius,
  curve_pitch,
  crossings
};
/// Whether a kind is measured along or about an axis, which must then be given.
bool needs_axis(MeasureKind kind);
/// Where rotations are compared.
enum class MeasureAt { nodes, points, centroid };

/// [[measure]]: a named scalar per frame.
struct Measure {
  Source source;
  Located<std::string> name;
  Located<MeasureKind> kind;
  Located<std::string> body;          ///< the name of a body that exists; may be left out when the shot has one body
  std::optional<Located<Axis>> axis;  ///< of kinds that need one
  std::optional<Located<Vec3>> about; ///< of torques and angular momenta [m]; absent: the middle of the nodes
  Located<MeasureAt> at;
  Located<PointRotations> rule;
  std::optional<Region> where; ///< only these nodes; absent: all
  Located<bool> relative;      ///< divided by the value in the first frame
};

/// [expect.X]: a measure in a frame lies within [min, max].
struct Expectation {
  Source source;
  Located<std::string> name;
  Located<std::string> measure;               ///< the name of a measure that exists
  std::optional<Located<std::int64_t>> frame; ///< absent: the last; of every_frame: the first
  Located<bool> every_frame;                  ///< on all frames from `frame` on
  std::optional<Located<double>> min, max;
  std::optional<Located<std::string>> sweep_case; ///< only in wedges of this case; absent: in all
  /// The value is first divided by that of the wedge of this case (all else equal).
  std::optional<Located<std::string>> ratio_to;
};

struct Shot {
  std::string file;      ///< as named by the user
  std::string directory; ///< of the file, "." when it has none
  ShotSettings shot;
  std::vector<Body> bodies;
  std::vector<Material> materials;
  std::vector<Fixed> fixed;
  std::vector<Drive> drives;
  std::vector<Load> loads;
  std::vector<Collider> colliders;
  std::vector<Look> looks;
  FemOptions fem;
  std::optional<ContactOptions> contact;
  MpmOptions mpm;
  RenderOptions render;
  std::vector<Measure> measures;
  std::vector<Expectation> expectations;
  std::optional<Located<std::string>> sweep_case; ///< the case of [sweep] that was applied
  std::shared_ptr<const ResolvedTree> resolved;   ///< the same as keys and values, for shots/resolved.h

  const Material* find_material(const std::string& name) const; ///< nullptr: there is none
  const Look* find_look(const std::string& name) const;         ///< nullptr: there is none
  const Body* find_body(const std::string& name) const;         ///< nullptr: there is none
  /// Whether a body is made of particles.
  bool is_particles(const Body& body) const;
};

} // namespace wry::shots
