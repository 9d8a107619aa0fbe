#include "sim/mpm/totals.h"

#include "sim/mpm/transfer_run.h"

namespace wry::mpm {

template <class Scalar>
Totals sum_totals(const MpmPlan& plan, const std::vector<BodyState<Scalar>>& bodies, const MpmState<Scalar>& state) {
  static constexpr std::size_t WIDTH = TILE_WIDTH<Scalar>;
  Totals sum;
  const double cell = plan.settings.cell;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const ParticleSet<Scalar>& particles = state.sets[b].particles;
    const double mass = bodies[b].mass;
    AlignedVector<Scalar> energy;
    for (const BlockRun& run : state.sets[b].runs) {
      const int tiles = static_cast<int>((static_cast<std::size_t>(run.count) + WIDTH - 1) / WIDTH);
      TransferRun<Scalar> transfer =
          transfer_run(bodies[b], const_cast<ParticleSet<Scalar>&>(particles), run, cell, 0.0); // read only
      transfer.tiles.count = tiles;
      energy.assign(static_cast<std::size_t>(tiles) * WIDTH, Scalar(0));
      bodies[b].kernels.energy(bodies[b].constants, transfer.tiles, energy.data());
      for (std::size_t i = 0; i < static_cast<std::size_t>(run.count); ++i) {
        const std::size_t place = static_cast<std::size_t>(run.first_tile) * WIDTH + i;
        const Vec3 x = world_position(particles, run, place, cell);
        Vec3 v;
        Mat3 affine;
        for (int c = 0; c < 3; ++c) {
          v[c] = particles.at(Channel::velocity, place, c);
          for (int a = 0; a < 3; ++a)
            affine(c, a) = particles.at(Channel::affine, place, c * 3 + a);
        }
        const double inertia = mass * cell * cell / 4.0;
        sum.mass += mass;
        sum.momentum += mass * v;
        const Mat3 skew = affine - affine.transpose();
        sum.angular_momentum += mass * x.cross(v) + inertia * Vec3(skew(2, 1), skew(0, 2), skew(1, 0));
        sum.kinetic_energy += 0.5 * mass * v.squaredNorm() + 0.5 * inertia * affine.squaredNorm();
        sum.gravity_energy -= mass * x.dot(plan.gravity);
        sum.elastic_energy += static_cast<double>(bodies[b].volume) * static_cast<double>(energy[i]);
      }
    }
  }
  return sum;
}

template Totals sum_totals<float>(const MpmPlan&, const std::vector<BodyState<float>>&, const MpmState<float>&);
template Totals sum_totals<double>(const MpmPlan&, const std::vector<BodyState<double>>&, const MpmState<double>&);

} // namespace wry::mpm
