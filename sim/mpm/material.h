#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/isa.h"
#include "sim/base/result.h"
#include "sim/base/types.h"
#include "sim/mpm/constitutive.h"
#include "sim/mpm/laws.h"

namespace wry::mpm {

/// Row-major 6x6, Mandel.
using Mandel = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
/// Values along the material's axes; all equal where the material is isotropic.
using PerAxis = std::array<double, 3>; ///< x, y, z

/// What an axis has when grains point anywhere, all along it, or all across it (spec S8).
struct AxisLimits {
  double youngs_modulus = 1e5; ///< [Pa]
  double poisson_ratio = 0.3;  ///< of the plane normal to the axis: sqrt(nu_ij nu_ji)
  double plastic_scale = 1.0;
};
/// Grains whose directions the flow turns. With it, moduli, ratios and plastic scales come from the limits.
struct Reorientation {
  double length_over_width = 5.0; ///< of a grain; below 1: a disc, whose direction is its normal
  AxisLimits isotropic, parallel, perpendicular;
};

/// A material as the shot gives it, in doubles and names (spec S2, S3, S5). Angles in radians.
struct Material {
  std::string name;
  double density = 1000.0; ///< [kg/m^3]
  Elasticity elasticity = Elasticity::hencky;
  Plasticity plasticity = Plasticity::none;

  PerAxis youngs_modulus{1e5, 1e5, 1e5}; ///< [Pa]
  struct {
    double yz = 0.3, xz = 0.3, xy = 0.3;
  } poisson_ratio; ///< nu_ij: contraction in j for extension in i
  /// [Pa]; absent: Li & Barbic
  struct Shear {
    double yz, zx, xy;
  };
  std::optional<Shear> shear_modulus;

  PerAxis plastic_scale{1, 1, 1};   ///< a of A^sigma : S = D S D, D = diag(a)
  std::optional<Mat3> plastic_map;  ///< D in full, in place of plastic_scale
  std::optional<Mandel> stress_map; ///< A^sigma in full (36 entries), in place of both
  std::optional<Mandel> strain_map; ///< A^E in full; absent: C bar^-1 A^sigma C tilde
  struct Isotropic {
    double youngs_modulus, poisson_ratio;
  };
  std::optional<Isotropic> fictitious; ///< C bar; absent: the Frobenius fit

  std::optional<Reorientation> reorientation; ///< absent: grains keep their place in the frame

  FrameMode frame = FrameMode::automatic;
  StrainMeasure measure = StrainMeasure::automatic;

  double friction_angle = 0.610865238198015; ///< phi; 35 degrees
  /// h0..h3 of phi(q) = h0 + (h1 q - h3) exp(-h2 q); absent: no hardening
  std::optional<std::array<double, 4>> friction_hardening;
  Flow flow = Flow::fictitious;
  bool volume_correction = false;
  double critical_compression = 0.025, critical_stretch = 0.0075, snow_hardening = 10.0;
  double shear_limit = 0.0025;

  bool fibre_varies = false;     ///< the frame differs between particles: channel `frame` from the scene
  bool stiffness_varies = false; ///< channel stiffness_scale from the scene
  bool strength_varies = false;  ///< channel strength_scale from the scene
};

/// What a material does without, and why.
struct LeftOut {
  enum class Part { frames_and_maps, maps, second_moment, maps_of_each_particle, hardening } part;
  std::string what, why;
};

/// A material ready to run. Its channels decide what particles carry; nothing else is allocated.
struct CompiledMaterial {
  std::vector<Channel> channels; ///< beyond the base ones
  MaterialConstants<double> constants;
  double sound_speed = 0.0;          ///< sqrt(max over directions of the acoustic tensor / density) [m/s]
  std::string runs;                  ///< "Hencky, Drucker-Prager phi 35, isotropic: no maps"
  std::vector<LeftOut> left_out;     ///< for `plan`
  std::vector<std::string> warnings; ///< hydrostatic flow, asymmetric A^E, ...
};

/// Checks and compiles. Errors: bad_input without a place (the caller adds the line): the violated inequality, both
/// sides, the admissible interval.
Result<CompiledMaterial> compile_material(const Material& material);

/// The kernels for a compiled material. Never null for what compile_material() accepts.
template <class Scalar> struct MaterialKernels {
  ConstitutiveKernel<Scalar> update = nullptr;
  EnergyKernel<Scalar> energy = nullptr;
  TangentKernel<Scalar> tangent; ///< of semi-implicit steps
};
template <class Scalar>
MaterialKernels<Scalar> find_material_kernels(const Material& material, const CompiledMaterial& compiled, Isa isa);

/// Constants in the scalar of the particles.
template <class Scalar> MaterialConstants<Scalar> constants_in(const MaterialConstants<double>& constants);

} // namespace wry::mpm
