#pragma once

#include "sim/mpm/constitutive.h"

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
