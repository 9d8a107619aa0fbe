#pragma once

#include "sim/mpm/constitutive.h"

namespace wry::mpm {

/// How many components the tangent kernels freeze per particle: a factor; local x and z in the world with it; the
/// shares of the grains along the axes with these.
inline constexpr int FROZEN_FACTOR = 1, FROZEN_AXES = 7, FROZEN_GRAINS = 10;

} // namespace wry::mpm

/// The kernels of matter, each in every instruction set and in both precisions.
#define WRY_MATTER_KERNEL(prefix, name, T)                                                                             \
  prefix ConstitutiveReport name<T>(const MaterialConstants<T>&, const ConstitutiveTiles<T>&);
#define WRY_ENERGY_KERNEL(prefix, name, T)                                                                             \
  prefix void name<T>(const MaterialConstants<T>&, const ConstitutiveTiles<T>&, T*);

#define WRY_MATTER_KERNELS_ISOTROPIC(prefix)                                                                           \
  WRY_MATTER_KERNEL(prefix, update_isotropic, float)                                                                   \
  WRY_MATTER_KERNEL(prefix, update_isotropic, double)                                                                  \
  WRY_MATTER_KERNEL(prefix, update_isotropic_series, float)                                                            \
  WRY_MATTER_KERNEL(prefix, update_isotropic_series, double)                                                           \
  WRY_ENERGY_KERNEL(prefix, energy_isotropic, float)                                                                   \
  WRY_ENERGY_KERNEL(prefix, energy_isotropic, double)

#define WRY_MATTER_KERNELS_ANISOTROPIC(prefix)                                                                         \
  WRY_MATTER_KERNEL(prefix, update_orthotropic, float)                                                                 \
  WRY_MATTER_KERNEL(prefix, update_orthotropic, double)                                                                \
  WRY_MATTER_KERNEL(prefix, update_general, float)                                                                     \
  WRY_MATTER_KERNEL(prefix, update_general, double)                                                                    \
  WRY_MATTER_KERNEL(prefix, update_reoriented, float)                                                                  \
  WRY_MATTER_KERNEL(prefix, update_reoriented, double)                                                                 \
  WRY_ENERGY_KERNEL(prefix, energy_anisotropic, float)                                                                 \
  WRY_ENERGY_KERNEL(prefix, energy_anisotropic, double)

#define WRY_FREEZE_KERNEL(prefix, name, T)                                                                             \
  prefix void name<T>(const MaterialConstants<T>&, const ConstitutiveTiles<T>&, T*);
#define WRY_TANGENT_KERNEL(prefix, name, T) prefix void name<T>(const MaterialConstants<T>&, const T*, T*);

#define WRY_MATTER_KERNELS_TANGENT(prefix)                                                                             \
  WRY_FREEZE_KERNEL(prefix, freeze_isotropic, float)                                                                   \
  WRY_FREEZE_KERNEL(prefix, freeze_isotropic, double)                                                                  \
  WRY_FREEZE_KERNEL(prefix, freeze_axes, float)                                                                        \
  WRY_FREEZE_KERNEL(prefix, freeze_axes, double)                                                                       \
  WRY_FREEZE_KERNEL(prefix, freeze_grains, float)                                                                      \
  WRY_FREEZE_KERNEL(prefix, freeze_grains, double)                                                                     \
  WRY_TANGENT_KERNEL(prefix, tangent_isotropic, float)                                                                 \
  WRY_TANGENT_KERNEL(prefix, tangent_isotropic, double)                                                                \
  WRY_TANGENT_KERNEL(prefix, tangent_orthotropic, float)                                                               \
  WRY_TANGENT_KERNEL(prefix, tangent_orthotropic, double)                                                              \
  WRY_TANGENT_KERNEL(prefix, tangent_general, float)                                                                   \
  WRY_TANGENT_KERNEL(prefix, tangent_general, double)                                                                  \
  WRY_TANGENT_KERNEL(prefix, tangent_reoriented, float)                                                                \
  WRY_TANGENT_KERNEL(prefix, tangent_reoriented, double)
