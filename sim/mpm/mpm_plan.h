#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/types.h"
#include "sim/mpm/grains/sub_particle_settings.h"
#include "sim/mpm/kernels/transfer.h"
#include "sim/mpm/material.h"
#include "sim/mpm/semi_implicit_settings.h"
#include "sim/scene/collider.h"

namespace wry::mpm {

enum class Precision { f32, f64 };

/// Matter of one material: where its particles start.
struct MpmBody {
  std::string name;
  std::string look; ///< of its pictures; empty: the default
  Material material;
  std::shared_ptr<const Points> positions; ///< of the particles at the start [m]
  double particle_volume = 0.0;            ///< at rest, alike for all [m^3]
  Vec3 initial_velocity = Vec3::Zero();    ///< [m/s]
  /// Velocity at a start position, added to initial_velocity; empty: none.
  std::function<Vec3(const Vec3&)> velocity_field;
  Mat3 frame = Mat3::Identity(); ///< Q at the start: columns are the material's axes in the world
  /// Per particle, a row each (w, x, y, z), in place of `frame`; needs material.fibre_varies.
  std::shared_ptr<const Quaternions> frames;
  Vec3 second_moment = Vec3::UnitZ();  ///< shares of the grains along the axes at the start; sum to 1
  std::vector<double> stiffness_scale; ///< per particle; empty: 1
  std::vector<double> strength_scale;  ///< per particle; empty: 1
  /// Grains that are drawn in place of the particles it starts with; absent: none, at no cost.
  std::optional<SubParticleSettings> sub_particles;
};

/// A part of space in which matter moves as prescribed.
struct HeldSpace {
  std::string name;
  scene::ObstacleShape shape;  ///< its inside
  scene::Motion motion;        ///< moves the space and gives the velocity in it
  std::optional<double> until; ///< let go after this time [s]
};

/// Matter that keeps coming: the particles of `body` are added again and again.
struct Source {
  std::string name;
  int body = 0;       ///< whose particles are repeated, with their velocity
  double every = 0.0; ///< [s]
  double from = 0.0;  ///< the first addition after the body's own start [s]
  double until = 0.0; ///< no addition after this time [s]
};

struct MpmSettings {
  double cell = 0.0; ///< h [m]
  Transfer transfer = Transfer::gradient;
  Precision precision = Precision::f32;
  double courant = 0.4;                      ///< kappa of dt <= kappa h / (c + |v|)
  double max_deformation = 0.3;              ///< of dt |L| in a step
  std::optional<double> time_step;           ///< [s]; cut where it is unstable
  std::optional<SemiImplicit> semi_implicit; ///< absent: explicit
  bool keep_fields = false;                  ///< MpmSimulation::take_fields() has what grains were carried by
};

/// Everything the material point method of a scene needs, immutable.
struct MpmPlan {
  std::vector<MpmBody> bodies;
  std::vector<std::shared_ptr<const scene::Collider>> colliders;
  std::vector<HeldSpace> held;
  std::vector<Source> sources;
  Vec3 gravity{0.0, -9.81, 0.0}; ///< [m/s^2]
  MpmSettings settings;
};

} // namespace wry::mpm
