#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "sim/base/parallel.h"
#include "sim/fem/fem_model.h"
#include "sim/fem/linear/block_matrix.h"

namespace wry::fem {

/// Which parts of a Hessian that are not positive semidefinite are made so.
enum class Projection {
  none,                  ///< exact
  contacts,              ///< those of contacts, which are cheap to project and rarely definite
  elements_with_inertia, ///< also elements that are indefinite even with half of their nodes' inertia
  elements,              ///< all, each by itself
};

inline bool is_of_elements(Projection projection) {
  return projection >= Projection::elements_with_inertia;
}

/// A part of the incremental potential, a function of the unknowns (v, omega) of all nodes. Terms may keep data that is
/// frozen during a solve (lagged friction, the rest shape of the time), renewed by begin_solve only.
class EnergyTerm {
public:
  virtual ~EnergyTerm() = default;
  virtual std::string_view name() const = 0;

  /// Goes back to the start of a step that is to be tried; `positions` are those of the nodes there.
  virtual void begin_step(const Stage& stage, const Points& positions) {
    (void)stage;
    (void)positions;
  }
  /// Takes what is prescribed (obstacles on their way) as far towards the end of the step as nodes in their present
  /// place allow. Returns the share of the way that is left.
  virtual double advance_prescribed(const Trial& trial) {
    (void)trial;
    return 0.0;
  }
  /// Freezes what does not vary during the coming solve. `trial` is the best known state of the stage's end.
  virtual void begin_solve(const Stage& stage, const Trial& trial) {
    (void)stage;
    (void)trial;
  }
  /// Whether its derivatives are by the Cayley increments of rotations times beta, not by omega itself.
  virtual bool acts_on_increments() const { return true; }
  /// [J]; +infinity where the term is not defined.
  virtual double energy(const Stage& stage, const Trial& trial) const = 0;
  /// Energy, and adds the derivative to `gradient` (packed).
  virtual double add_gradient(const Stage& stage, const Trial& trial, std::vector<double>& gradient) const = 0;
  /// Adds the second derivative; returns how many element Hessians had to be projected.
  virtual int add_hessian(const Stage& stage, const Trial& trial, Projection projection, BlockMatrix& matrix) const = 0;
  /// While set, the second derivative of friction is replaced by one that bounds the energy from above: a direction
  /// then does not leap over the kink between sticking and sliding, at the price of slower convergence near the
  /// minimum.
  virtual void bound_friction(bool on) { (void)on; }
  /// The largest fraction in (0, 1] of a change of positions that is sure to stay where the term is defined.
  virtual double step_limit(const Trial& trial, const Points& position_change) const {
    (void)trial;
    (void)position_change;
    return 1.0;
  }
};

/// A row of the table of terms: its name, and how it is made; nullptr if the model has no use for it.
struct EnergyTermEntry {
  std::string_view name;
  std::unique_ptr<EnergyTerm> (*make)(const FemModel& model, const ContactState& contact);
};

/// All terms that act on nodes. Elements (element_term.h) stand beside them.
std::span<const EnergyTermEntry> energy_term_table();

} // namespace wry::fem
