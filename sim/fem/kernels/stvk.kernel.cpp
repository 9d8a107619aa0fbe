#include "sim/fem/kernels/classic.h"

/// St. Venant-Kirchhoff: mu |E|^2 + lambda/2 tr(E)^2, E = (F^T F - I) / 2.
namespace wry::fem::WRY_ISA {

namespace {

struct StVenantKirchhoff {
  template <Order ORDER> WRY_INLINE static void add(const Element& element, PositionPart& part) {
    const Mat F = deformation_gradient(element);
    const Sym E = broadcast(0.5) * plus_identity(square(transposed(F)), broadcast(-1.0));
    const Real trace_E = E.xx + E.yy + E.zz;
    const Real mu = element.volume * element.mu, lambda = element.volume * element.lambda;
    const Sym stress = plus_identity((2.0 * mu) * E, lambda * trace_E);
    part.energy += 0.5 * (stress.xx * E.xx + stress.yy * E.yy + stress.zz * E.zz) + stress.xy * E.xy +
                   stress.xz * E.xz + stress.yz * E.yz;
    if constexpr (ORDER == Order::energy)
      return;
    const Vec* g = element.gradients;
    const Vec traction[3] = {stress * g[0], stress * g[1], stress * g[2]};
    for (int k = 0; k < 3; ++k)
      part.force[k] = part.force[k] + F * traction[k];
    if constexpr (ORDER == Order::gradient)
      return;

    // With f_k = F grad phi_k: (g_k.S g_l + mu g_k.g_l F F^T) + mu f_l f_k^T + lambda f_k f_l^T
    const Sym left_cauchy_green = square(F);
    const Vec f[3] = {F * g[0], F * g[1], F * g[2]};
    int i = 0;
    for (int k = 0; k < 3; ++k) {
      for (int l = k; l < 3; ++l, ++i) {
        const Sym both = plus_identity((mu * dot(g[k], g[l])) * left_cauchy_green, dot(traction[k], g[l]));
        part.blocks[i] = part.blocks[i] + full(both) + outer(mu * f[l], f[k]) + outer(lambda * f[k], f[l]);
      }
    }
  }
};

} // namespace

extern const ModelKernel stvk;
const ModelKernel stvk = classic_kernel<StVenantKirchhoff>();

} // namespace wry::fem::WRY_ISA
