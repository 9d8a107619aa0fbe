#include <array>

#include "sim/fem/terms/energy_term.h"
#include "sim/fem/terms/node_terms.h"

namespace wry::fem {

std::span<const EnergyTermEntry> energy_term_table() {
  static constexpr std::array TABLE = {
      EnergyTermEntry{"inertia", &make_inertia},
      EnergyTermEntry{"rotary_inertia", &make_rotary_inertia},
      EnergyTermEntry{"gravity", &make_gravity},
      EnergyTermEntry{"loads", &make_loads},
      EnergyTermEntry{"drive_springs", &make_drive_springs},
      EnergyTermEntry{"mass_damping", &make_mass_damping},
      EnergyTermEntry{"plane_barrier", &make_plane_barrier},
      EnergyTermEntry{"plane_friction", &make_plane_friction},
      EnergyTermEntry{"pair_barrier", &make_pair_barrier},
      EnergyTermEntry{"pair_friction", &make_pair_friction},
  };
  return TABLE;
}

} // namespace wry::fem
