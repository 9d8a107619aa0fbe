#include "sim/fem/kernels/points.h"

namespace wry::fem::WRY_ISA {

void advance_point_rotations(const Batch& batch, const NodeFields& fields, double* point_rotations) {
  for (int lane = 0; lane < LANES; lane += WIDTH) {
    Vec increments[POINTS];
    interpolate(batch, fields, lane, increments);
    for (int p = 0; p < POINTS; ++p) {
      double* to = point_rotations + 4 * p * LANES + lane;
      const Quat q0 = load_quat(to);
      const Quat q = q0 + (broadcast(0.5) * increments[p]) * q0;
      // The norm of q, not 1/n: rounding errors of many steps do not add up.
      const Quat unit = (1.0 / sqrt(dot(q, q))) * q;
      store(to, unit.w);
      store(to + LANES, unit.x);
      store(to + 2 * LANES, unit.y);
      store(to + 3 * LANES, unit.z);
    }
  }
}

} // namespace wry::fem::WRY_ISA
