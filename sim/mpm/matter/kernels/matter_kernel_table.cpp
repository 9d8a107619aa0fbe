#include <algorithm>

#include "sim/mpm/material.h"
#include "sim/mpm/matter/kernels/matter_kernels.h"

namespace wry::mpm {

#define WRY_DECLARE(isa)                                                                                               \
  namespace isa {                                                                                                      \
  template <class T> ConstitutiveReport update_isotropic(const MaterialConstants<T>&, const ConstitutiveTiles<T>&);    \
  template <class T>                                                                                                   \
  ConstitutiveReport update_isotropic_series(const MaterialConstants<T>&, const ConstitutiveTiles<T>&);                \
  template <class T> ConstitutiveReport update_orthotropic(const MaterialConstants<T>&, const ConstitutiveTiles<T>&);  \
  template <class T> ConstitutiveReport update_general(const MaterialConstants<T>&, const ConstitutiveTiles<T>&);      \
  template <class T> ConstitutiveReport update_reoriented(const MaterialConstants<T>&, const ConstitutiveTiles<T>&);   \
  template <class T> void energy_isotropic(const MaterialConstants<T>&, const ConstitutiveTiles<T>&, T*);              \
  template <class T> void energy_anisotropic(const MaterialConstants<T>&, const ConstitutiveTiles<T>&, T*);            \
  WRY_MATTER_KERNELS_ISOTROPIC(extern template)                                                                        \
  WRY_MATTER_KERNELS_ANISOTROPIC(extern template)                                                                      \
  template <class T> void freeze_isotropic(const MaterialConstants<T>&, const ConstitutiveTiles<T>&, T*);              \
  template <class T> void freeze_axes(const MaterialConstants<T>&, const ConstitutiveTiles<T>&, T*);                   \
  template <class T> void freeze_grains(const MaterialConstants<T>&, const ConstitutiveTiles<T>&, T*);                 \
  template <class T> void tangent_isotropic(const MaterialConstants<T>&, const T*, T*);                                \
  template <class T> void tangent_orthotropic(const MaterialConstants<T>&, const T*, T*);                              \
  template <class T> void tangent_general(const MaterialConstants<T>&, const T*, T*);                                  \
  template <class T> void tangent_reoriented(const MaterialConstants<T>&, const T*, T*);                               \
  WRY_MATTER_KERNELS_TANGENT(extern template)                                                                          \
  }
WRY_DECLARE(sse4)
WRY_DECLARE(avx2)
WRY_DECLARE(avx512)
#undef WRY_DECLARE

namespace {

/// All kernels of one instruction set and precision.
template <class T> struct Kernels {
  ConstitutiveKernel<T> isotropic, isotropic_series, orthotropic, general, reoriented;
  EnergyKernel<T> isotropic_energy, anisotropic_energy;
  TangentKernel<T> isotropic_tangent, orthotropic_tangent, general_tangent, reoriented_tangent;
};

#define WRY_ENTRY(isa)                                                                                                 \
  {                                                                                                                    \
    isa::update_isotropic<T>, isa::update_isotropic_series<T>, isa::update_orthotropic<T>, isa::update_general<T>,     \
        isa::update_reoriented<T>, isa::energy_isotropic<T>, isa::energy_anisotropic<T>,                               \
        {FROZEN_FACTOR, isa::freeze_isotropic<T>, isa::tangent_isotropic<T>},                                          \
        {FROZEN_AXES, isa::freeze_axes<T>, isa::tangent_orthotropic<T>},                                               \
        {FROZEN_AXES, isa::freeze_axes<T>, isa::tangent_general<T>}, {                                                 \
      FROZEN_GRAINS, isa::freeze_grains<T>, isa::tangent_reoriented<T>                                                 \
    }                                                                                                                  \
  }
template <class T> const Kernels<T>& kernels_of(Isa isa) {
  static constexpr Kernels<T> TABLE[] = {WRY_ENTRY(sse4), WRY_ENTRY(avx2), WRY_ENTRY(avx512)};
  return TABLE[static_cast<int>(isa)];
}
#undef WRY_ENTRY

/// Hencky's law alone or with Drucker-Prager, isotropic: the axes of V are never needed while strains are small.
bool goes_without_axes(const MaterialConstants<double>& constants) {
  return constants.elasticity_law == Elasticity::hencky &&
         (constants.plasticity == Plasticity::none || constants.plasticity == Plasticity::drucker_prager);
}

template <class T> ConstitutiveKernel<T> update_of(const Kernels<T>& all, const CompiledMaterial& compiled) {
  const auto& constants = compiled.constants;
  const bool has_axes =
      std::find(compiled.channels.begin(), compiled.channels.end(), Channel::frame) != compiled.channels.end();
  if (!has_axes)
    return goes_without_axes(constants) ? all.isotropic_series : all.isotropic;
  if (constants.reorients)
    return all.reoriented;
  return constants.block_maps ? all.orthotropic : all.general;
}

template <class T> const TangentKernel<T>& tangent_of(const Kernels<T>& all, ConstitutiveKernel<T> update) {
  if (update == all.reoriented)
    return all.reoriented_tangent;
  if (update == all.general)
    return all.general_tangent;
  return update == all.orthotropic ? all.orthotropic_tangent : all.isotropic_tangent;
}

} // namespace

template <class Scalar>
MaterialKernels<Scalar> find_material_kernels(const Material&, const CompiledMaterial& compiled, Isa isa) {
  const Kernels<Scalar>& all = kernels_of<Scalar>(isa);
  const ConstitutiveKernel<Scalar> update = update_of(all, compiled);
  const bool isotropic = update == all.isotropic || update == all.isotropic_series;
  return {update, isotropic ? all.isotropic_energy : all.anisotropic_energy, tangent_of(all, update)};
}
template MaterialKernels<float> find_material_kernels<float>(const Material&, const CompiledMaterial&, Isa);
template MaterialKernels<double> find_material_kernels<double>(const Material&, const CompiledMaterial&, Isa);

} // namespace wry::mpm
