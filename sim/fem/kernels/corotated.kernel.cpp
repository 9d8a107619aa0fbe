#include "sim/fem/kernels/classic.h"
#include "sim/fem/kernels/polar.h"

/// mu |F - R|^2 + lambda/2 tr(R^T F - I)^2 with the rotation R nearest to F: the micropolar energy of micropolar.h
/// whose rotation follows F, V = F R^T symmetric.
namespace wry::fem::WRY_ISA {

namespace {

/// (tr V I - V)^-1: how far R turns for a given couple. Bounded where two principal stretches cancel and R is not
/// unique.
WRY_INLINE Sym turn_compliance(const Sym& V) {
  const Real tr = V.xx + V.yy + V.zz;
  const Sym A = {tr - V.xx, -V.xy, -V.xz, tr - V.yy, -V.yz, tr - V.zz};
  const Sym cofactor = {A.yy * A.zz - A.yz * A.yz, A.xz * A.yz - A.xy * A.zz, A.xy * A.yz - A.xz * A.yy,
                        A.xx * A.zz - A.xz * A.xz, A.xy * A.xz - A.xx * A.yz, A.xx * A.yy - A.xy * A.xy};
  const Real det = A.xx * cofactor.xx + A.xy * cofactor.xy + A.xz * cofactor.xz;
  const Real size = A.xx + A.yy + A.zz;
  const Real least = 1e-12 * size * size * size + 1e-300;
  const Real bounded = det > least ? det : least;
  return (1.0 / bounded) * cofactor;
}

struct Corotated {
  template <Order ORDER> WRY_INLINE static void add(const Element& element, PositionPart& part) {
    const Mat F = deformation_gradient(element);
    const Mat R = nearest_rotation(F);
    const Sym V = symmetric_part(F * transposed(R));
    const Sym W = plus_identity(V, broadcast(-1.0));
    const Real mu = element.volume * element.mu, lambda = element.volume * element.lambda;
    const Real tr = W.xx + W.yy + W.zz;
    part.energy += mu * (W.xx * W.xx + W.yy * W.yy + W.zz * W.zz + 2.0 * (W.xy * W.xy + W.xz * W.xz + W.yz * W.yz)) +
                   0.5 * lambda * tr * tr;
    if constexpr (ORDER == Order::energy)
      return;
    const Vec* g = element.gradients;
    const Vec b[3] = {R * g[0], R * g[1], R * g[2]};
    const Sym stress = plus_identity((2.0 * mu) * W, lambda * tr);
    for (int k = 0; k < 3; ++k)
      part.force[k] = part.force[k] + stress * b[k];
    if constexpr (ORDER == Order::gradient)
      return;

    // 2 mu g_k.g_l I + lambda b_k b_l^T - s cross(b_k) (tr V I - V)^-1 cross(b_l), s = lambda tr W - 2 mu
    const Real s = lambda * tr - 2.0 * mu;
    const Mat compliance = full(s * turn_compliance(V));
    int i = 0;
    for (int k = 0; k < 3; ++k) {
      const Mat turned = -cross(b[k], compliance);
      for (int l = k; l < 3; ++l, ++i) {
        // m cross(b), row by row: r cross(b) = r x b
        const Mat turn = {cross(turned.r0, b[l]), cross(turned.r1, b[l]), cross(turned.r2, b[l])};
        part.blocks[i] = part.blocks[i] + plus_identity(turn + outer(lambda * b[k], b[l]), 2.0 * mu * dot(g[k], g[l]));
      }
    }
  }
};

} // namespace

extern const ModelKernel corotated;
const ModelKernel corotated = classic_kernel<Corotated>();

} // namespace wry::fem::WRY_ISA
