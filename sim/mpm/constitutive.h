#pragma once

#include "sim/mpm/channels.h"
#include "sim/mpm/laws.h"

/// Where transfers and materials meet. Seen by kernel files: plain structs, no standard library.
///
/// The order of a step is P2G(tau, C) -> grid -> G2P, and G2P calls the material's kernel for the tiles whose L it has
/// just gathered, while they are in the cache: F and the state are brought up to date, and tau is ready for the next
/// P2G (spec S4, S6).
namespace wry::mpm {

/// Material constants in the scalar that the particles have, rounded once from double. One per set of particles (a body
/// of one material). Those that a kernel does not read are zero. Laws add theirs here.
template <class Scalar> struct MaterialConstants {
  Elasticity elasticity_law = Elasticity::hencky;
  Plasticity plasticity = Plasticity::none;
  StrainMeasure measure = StrainMeasure::hencky; ///< never automatic
  Flow flow = Flow::fictitious;
  FrameMode frame = FrameMode::shape; ///< never automatic
  bool hardens = false;               ///< friction depends on the flow so far
  bool corrects_volume = false;       ///< v_c
  bool uses_maps = false;             ///< A^E and its inverses are read; else the stiffness alone
  bool block_maps = true;             ///< maps mix normal components only
  bool reorients = false;             ///< maps come from each particle's second moment
  // Isotropic: of the material itself, or of the fictitious material (C bar).
  Scalar lambda = 0; ///< [Pa]
  Scalar mu = 0;     ///< [Pa]
  // Anisotropic, Mandel 6x6 row-major (xx yy zz yz zx xy, shears with sqrt 2), in the material's axes.
  Scalar elasticity[36] = {};         ///< C tilde [Pa]
  Scalar strain_map[36] = {};         ///< A^E
  Scalar strain_map_inverse[36] = {}; ///< (A^E)^-1
  Scalar stress_map_inverse[36] = {}; ///< (A^sigma)^-1
  // Drucker-Prager.
  Scalar friction_angle[4] = {}; ///< h0..h3 [rad, 1, 1, rad]; without hardening {phi, 0, 0, 0}
  Scalar friction_alpha = 0;     ///< alpha at q = 0
  // Snow.
  Scalar critical_compression = 0, critical_stretch = 0, snow_hardening = 0; ///< theta_c, theta_s, xi
  // Shear-limited.
  Scalar shear_limit = 0; ///< k
  // Grains that reorient: limits {isotropic, parallel, perpendicular} of an axis.
  Scalar axis_modulus[3] = {}; ///< E [Pa]
  Scalar axis_ratio[3] = {};   ///< nu of the plane normal to the axis
  Scalar axis_scale[3] = {};   ///< plastic scale
  Scalar jeffery = 0;          ///< l = (r^2 - 1) / (r^2 + 1)
};

/// A run of consecutive whole tiles of one set. Pointers are to the first tile, 64-byte aligned, laid out as
/// channels.h says; those of channels that the material did not declare are null.
template <class Scalar> struct ConstitutiveTiles {
  int count = 0;                             ///< of tiles
  Scalar dt = 0;                             ///< [s]
  const Scalar* velocity_gradient = nullptr; ///< L, 9 components, row-major dv_i/dx_j [1/s]
  const Scalar* affine = nullptr;            ///< C, 9 components [1/s]: what turns the frame in `shape` mode, new value
  Scalar* deformation = nullptr;             ///< F_e, in and out
  Scalar* stress = nullptr;                  ///< tau, out; 6 components without factors
  Scalar* state[CHANNEL_COUNT] = {};         ///< by Channel; only those beyond the base ones, in and out

  Scalar* of(Channel channel) const { return state[static_cast<int>(channel)]; }
};

/// What a kernel tells about a run of tiles.
struct ConstitutiveReport {
  /// A lane where F became or was not finite, or det(I + dt L) <= 0 or det F <= 0; -1: none. Counted from the first
  /// lane of the run. The run stops the step.
  int failed_lane = -1;
  /// The greatest factor by which the stiffness of a lane exceeds that of the material at rest (snow that has
  /// compacted); the wave speed grows with its square root. 1: constant.
  double stiffness_factor = 1.0;

  void add(const ConstitutiveReport& other, int first_lane) {
    if (failed_lane < 0 && other.failed_lane >= 0)
      failed_lane = first_lane + other.failed_lane;
    if (other.stiffness_factor > stiffness_factor)
      stiffness_factor = other.stiffness_factor;
  }
};

/// The update of one combination of law, plasticity and anisotropy.
template <class Scalar>
using ConstitutiveKernel = ConstitutiveReport (*)(const MaterialConstants<Scalar>& material,
                                                  const ConstitutiveTiles<Scalar>& tiles);

/// Strain energy per rest volume of every lane [J/m^3], `energy` a component of its own, from F and state as they are.
template <class Scalar>
using EnergyKernel = void (*)(const MaterialConstants<Scalar>& material, const ConstitutiveTiles<Scalar>& tiles,
                              Scalar* energy);

/// How the stress of particles answers a rate of strain, for semi-implicit steps: sigma = s Q C (Q^T D Q) Q^T with the
/// frame and the factor s as they were when frozen. Not differentiated through the yield: where matter flows this is
/// stiffer than it is.
template <class Scalar> struct TangentKernel {
  int components = 0; ///< of what is frozen, per particle
  /// From the state as it is.
  void (*freeze)(const MaterialConstants<Scalar>& material, const ConstitutiveTiles<Scalar>& tiles,
                 Scalar* frozen) = nullptr;
  /// Of one tile, in place: `rate` is D, and then sigma; six components without factors.
  void (*stress)(const MaterialConstants<Scalar>& material, const Scalar* frozen, Scalar* rate) = nullptr;
};

} // namespace wry::mpm
