#pragma once

#include "sim/mpm/kernels/transfer_table.h"
#include "sim/mpm/mpm_state.h"

namespace wry::mpm {

/// A run of a body's particles as the kernels take it, for a step of `dt` on cells of size `cell`.
template <class Scalar>
TransferRun<Scalar> transfer_run(const BodyState<Scalar>& body, ParticleSet<Scalar>& particles, const BlockRun& run,
                                 double cell, double dt) {
  const std::size_t tile = static_cast<std::size_t>(run.first_tile);
  TransferRun<Scalar> transfer;
  transfer.count = run.count;
  transfer.dt = static_cast<Scalar>(dt);
  transfer.cell = static_cast<Scalar>(cell);
  transfer.mass = body.mass;
  transfer.volume = body.volume;
  transfer.position = particles.tile(Channel::position, tile);
  transfer.velocity = particles.tile(Channel::velocity, tile);
  transfer.affine = particles.tile(Channel::affine, tile);
  transfer.material = &body.constants;
  transfer.update = body.kernels.update;
  transfer.tiles.dt = static_cast<Scalar>(dt);
  transfer.tiles.deformation = particles.tile(Channel::deformation, tile);
  transfer.tiles.stress = particles.tile(Channel::stress, tile);
  for (int i = static_cast<int>(LAST_BASE_CHANNEL) + 1; i < CHANNEL_COUNT; ++i)
    transfer.tiles.state[i] = particles.tile(static_cast<Channel>(i), tile);
  return transfer;
}

} // namespace wry::mpm
