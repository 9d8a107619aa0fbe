#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "shots/source.h"
#include "sim/base/types.h"

/// What a shot says about the material point method; part of shots/shot.h.
namespace wry::shots {

/// A number, or a formula of t, X, Y, Z, u, v and mesh attributes; syntax is checked by whoever compiles it.
struct Expression {
  std::string text;               ///< numbers too, with all digits
  std::optional<double> constant; ///< set when a plain number was given
};

/// Three numbers by name, or one for all.
struct PerAxis {
  std::array<Located<double>, 3> values; ///< x, y, z; of Poisson's ratios yz, xz, xy
  bool is_table = false;
};

enum class Elasticity { linear, hencky, fixed_corotated };
enum class Plasticity { none, snow, drucker_prager, shear };
enum class MaterialFrame { automatic, polar, shape, fixed };
enum class StrainMeasure { automatic, hencky, biot };
enum class PlasticFlow { fictitious, isochoric };

/// What grains that reorient have along an axis.
struct ReorientLimit {
  Located<double> youngs_modulus, poisson_ratio, plastic_scale; ///< [Pa]
};
/// reorient = { ... } of a material.
struct Reorient {
  Source source;
  Located<double> length_over_width;
  std::optional<ReorientLimit> isotropic, parallel, perpendicular;
};

enum class GrainForm { rod, straw, card, coin, brick, sphere };
/// sub_particles = { ... } of a body.
struct SubParticleOptions {
  Source source;
  Located<std::int64_t> per_particle;
  Located<GrainForm> shape;                 ///< unless there is a mesh
  std::optional<Located<std::string>> mesh; ///< an artist's
  Located<std::size_t> mesh_along;          ///< which axis of the mesh's file lies along the fibre
  std::optional<Located<Vec3>> size;        ///< [m]; absent: the mesh's own
  Located<double> size_variation, spread_deg;
  Located<std::int64_t> seed;
  Located<double> escape_density, capture_density, travel;
};

/// The keys of [material.X] that only model = "mpm" reads.
struct Matter {
  Located<Elasticity> elasticity;
  Located<Plasticity> plasticity;
  PerAxis youngs_modulus, poisson_ratio;                       ///< [Pa]; yz, xz, xy
  std::optional<std::array<Located<double>, 3>> shear_modulus; ///< yz, zx, xy [Pa]
  PerAxis plastic_scale;
  std::optional<Located<Mat3>> plastic_map;                  ///< D
  std::optional<Located<std::array<double, 36>>> stress_map; ///< A^sigma, Mandel, row-major
  std::optional<Located<std::array<double, 36>>> strain_map; ///< A^E
  struct Fictitious {
    Source source;
    Located<double> youngs_modulus, poisson_ratio;
  };
  std::optional<Fictitious> fictitious;
  Located<MaterialFrame> frame;
  Located<StrainMeasure> measure;
  Located<double> friction_angle;                                   ///< degrees
  std::optional<Located<std::array<double, 4>>> friction_hardening; ///< h0..h3, degrees
  Located<PlasticFlow> flow;
  Located<bool> volume_correction;
  Located<double> critical_compression, critical_stretch, snow_hardening;
  Located<double> shear_limit;
  std::optional<Located<Expression>> stiffness_scale, strength_scale; ///< of X, Y, Z
  std::optional<Reorient> reorient;
  std::vector<Source> given; ///< those of these keys that are not at their defaults
};

struct BoxSpace {
  Located<Vec3> min, max;
};
struct SphereSpace {
  Located<Vec3> centre;
  Located<double> radius;
};
struct CylinderSpace {
  Located<Vec3> from, to;
  Located<double> radius;
};

/// region = { ... } of a body.
struct ParticleRegion {
  Source source;
  std::variant<BoxSpace, SphereSpace, CylinderSpace> space; ///< [m]
  std::optional<Located<Expression>> expression;            ///< only where it is not 0
};

/// fibre = { ... } of a body.
struct Fibre {
  Source source;
  std::optional<Located<Vec3>> direction;                                      ///< not normalised
  std::optional<Located<double>> tilt_deg;                                     ///< from up
  Located<double> azimuth_deg;                                                 ///< about up
  std::optional<std::array<std::optional<Located<Expression>>, 3>> expression; ///< absent components are 0
  std::optional<Located<Vec3>> second_moment;                                  ///< shares along local x, y, z
  std::optional<Located<Vec3>> across; ///< local x, before it is made perpendicular
};

/// source = { ... } of a body.
struct ParticleSource {
  Source source;
  Located<double> every, until; ///< [s]
};

/// The keys of a body whose material is of the material point method.
struct ParticleBody {
  std::optional<ParticleRegion> region; ///< absent: the inside of the body's shape
  Located<double> per_cell;
  std::optional<Fibre> fibre;
  std::optional<ParticleSource> repeat;
  std::optional<SubParticleOptions> grains;
};

enum class GridTransfer { gradient, mls };
enum class NumberPrecision { f32, f64 };
enum class ParticleSampling { lattice, jittered };

/// semi_implicit = { ... } of [mpm].
struct SemiImplicitOptions {
  Located<double> courant, implicitness, damping, tolerance;
};

/// [mpm]; nullopt stands for "auto".
struct MpmOptions {
  Source source;
  std::optional<Located<double>> cell_size; ///< [m]
  Located<GridTransfer> transfer;
  Located<NumberPrecision> precision;
  Located<ParticleSampling> sampling;
  std::optional<Located<double>> time_step; ///< [s]
  Located<double> courant, max_deformation;
  Located<bool> keep_fields;                        ///< that carry grains
  std::optional<SemiImplicitOptions> semi_implicit; ///< absent: explicit steps
};

} // namespace wry::shots
