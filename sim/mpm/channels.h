#pragma once

#include <cstddef>

namespace wry::mpm {

/// Particles stand in tiles: a tile is as many particles as fill a cache line with one component. A channel is an array
/// of tiles, and within a tile component c of particle p stands at [c * TILE_WIDTH<Scalar> + p]:
///
///     channel[(tile * components + c) * TILE_WIDTH + lane]
///
/// Kernels take lanes WIDTH = Pack<Scalar> at a time (a tile is 1, 2 or 4 packs). Every lane of a tile may be computed:
/// lanes past the end of a run hold a copy of its last particle, and what is computed for them is dropped.
template <class Scalar> inline constexpr int TILE_WIDTH = 64 / static_cast<int>(sizeof(Scalar));

/// What a particle can carry, and how many components it has. position to identity are always there; the rest is
/// allocated only where a material declares it (CompiledMaterial::channels). A new quantity is a line here: sorting,
/// checkpoints and the bytes in `plan` follow. `initial` is the value of every component at the start, unless the
/// scene gives one.
///
///   WRY_CHANNEL(name, components, initial)
#define WRY_MPM_CHANNELS(WRY_CHANNEL)                                                                                  \
  WRY_CHANNEL(position, 3, 0)          /* relative to its block's first node, in cells */                              \
  WRY_CHANNEL(velocity, 3, 0)          /* [m/s] */                                                                     \
  WRY_CHANNEL(affine, 9, 0)            /* C of APIC, row-major dv_i/dx_j [1/s] */                                      \
  WRY_CHANNEL(deformation, 9, 0)       /* F_e, row-major; starts as the identity */                                    \
  WRY_CHANNEL(stress, 6, 0)            /* Kirchhoff tau: xx yy zz yz zx xy, no factors [Pa] */                         \
  WRY_CHANNEL(identity, 1, 0)          /* which particle it is: its index in frames, as bits of an integer */          \
  WRY_CHANNEL(hardening, 1, 0)         /* q of Drucker-Prager */                                                       \
  WRY_CHANNEL(plastic_volume, 1, 1)    /* J_p of snow */                                                               \
  WRY_CHANNEL(volume_correction, 1, 0) /* v_c of Drucker-Prager, spec S5 */                                            \
  WRY_CHANNEL(frame, 4, 0)             /* Q, local -> global, unit quaternion w x y z; in polar mode Q0 */             \
  WRY_CHANNEL(second_moment, 6, 0)     /* Pi in the local frame: xx yy zz yz zx xy, trace 1 */                         \
  WRY_CHANNEL(stiffness_scale, 1, 1)   /* factor on all moduli where they vary in space */                             \
  WRY_CHANNEL(strength_scale, 1, 1)    /* factor on the yield limit where it varies in space */

enum class Channel {
#define WRY_CHANNEL(name, components, initial) name,
  WRY_MPM_CHANNELS(WRY_CHANNEL)
#undef WRY_CHANNEL
};

struct ChannelInfo {
  const char* name;
  int components;
  double initial;
};

inline constexpr ChannelInfo CHANNELS[] = {
#define WRY_CHANNEL(name, components, initial) {#name, components, initial},
    WRY_MPM_CHANNELS(WRY_CHANNEL)
#undef WRY_CHANNEL
};

inline constexpr int CHANNEL_COUNT = static_cast<int>(sizeof(CHANNELS) / sizeof(CHANNELS[0]));

/// The channels up to this one are what the method itself needs.
inline constexpr Channel LAST_BASE_CHANNEL = Channel::identity;

inline constexpr const ChannelInfo& channel_info(Channel channel) {
  return CHANNELS[static_cast<int>(channel)];
}

} // namespace wry::mpm
