#pragma once

#include <algorithm>
#include <vector>

#include "sim/fem/terms/energy_term.h"

namespace wry::fem {

/// How the lumped mass of nodes is shared out to the elements around them, by volume. Half of it is what an element may
/// lean on when its Hessian is asked to be positive semidefinite: the sum over all elements and the inertia of the
/// nodes is then at least the other half, so it is positive definite.
class InertiaShares {
public:
  /// To be called for each node of each element, with the element's volume [m^3]; then finish().
  void add_corner(int node, double volume) {
    const std::size_t i = static_cast<std::size_t>(node);
    if (i >= m_half_density.size())
      m_half_density.resize(i + 1, 0.0);
    m_half_density[i] += volume;
  }
  /// Mass of each node by its index in the model [kg].
  void finish(const std::vector<double>& mass) {
    for (std::size_t i = 0; i < m_half_density.size(); ++i)
      m_half_density[i] = m_half_density[i] > 0.0 ? 0.5 * std::max(0.0, mass[i]) / m_half_density[i] : 0.0;
  }

  /// What the projection of an element's Hessian by positions may add on the diagonal of a node [N/m].
  double at(int node, double volume, const Stage& stage, Projection projection) const {
    if (projection != Projection::elements_with_inertia)
      return 0.0;
    return m_half_density[static_cast<std::size_t>(node)] * volume / (stage.beta * stage.beta);
  }

private:
  std::vector<double> m_half_density; ///< volume around a node; once finished, half its mass by that
};

} // namespace wry::fem
