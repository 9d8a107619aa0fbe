#pragma once

namespace wry::fem {

/// The barrier of eq 19 and its derivatives by the distance d, for 0 < d; all zero at and beyond d-hat. Convex and
/// decreasing. `stiffness` is k_c [N/m].
struct Barrier {
  double value = 0.0;  ///< [J]
  double slope = 0.0;  ///< [N]
  double second = 0.0; ///< [N/m]
};
Barrier evaluate_barrier(double distance, double activation_distance, double stiffness);

} // namespace wry::fem
