#include "shots/schema.h"

namespace wry::shots {

Section fem_section() {
  Section section;
  section.doc = "How solids are solved.";
  section.fields = {
      choice("integrator",
             {{"backward-euler", "first order, damps what the step cannot resolve", ""},
              {"bdf2", "second order; remembers the step before", ""},
              {"sdirk2", "second order in two solves per step, damps only what the step cannot resolve", ""}},
             "The time integrator.")
          .standard("backward-euler"),
      number("time_step", "s", positive(10.0), "Longest step; steps land on frames, are cut on failure and grow again.")
          .called("time")
          .or_word("auto", "a step per frame, at most 10 ms"),
      number("min_time_step", "s", positive(10.0), "Shortest step; below it the run stops with exit code 70.")
          .called("time")
          .standard(1e-7),
      number("newton_tolerance", "N s", positive(1e6),
             "Newton stops when the gradient of the incremental potential is below.")
          .called("tolerance")
          .standard(1e-8),
      integer("max_newton_iterations", between(1, 100'000), "Iterations before a step is cut.").standard(250),
      choice("linear_solver",
             {{"auto", "chosen by size and stiffness; `wry plan` says why", ""},
              {"pcg", "conjugate gradients with block-Jacobi", ""},
              {"cholesky", "a sparse factor per iteration", ""},
              {"stale-cholesky", "an old factor as preconditioner", ""}},
             "How linear systems are solved.")
          .standard("auto"),
      number("linear_tolerance", "", strictly_between(0.0, 1.0), "Relative residual of linear solves.")
          .called("tolerance")
          .or_word("auto", "as exact as Newton needs it"),
      number("contact_distance", "m", positive(1e6), "d-hat: the distance at which obstacles begin to push.")
          .called("distance")
          .or_word("auto", "from the size of the scene"),
      number("contact_stiffness", "N/m", positive(), "kappa: how hard they push.")
          .called("stiffness")
          .or_word("auto", "from the stiffness of the bodies"),
      number("friction_velocity", "m/s", positive(1e3), "Slip slower than this is treated as sticking.")
          .called("speed")
          .standard(1e-3),
      choice("rotation_update",
             {{"cayley", "q + dt/2 omega q made unit (eq 26): falls short by |dt omega|^3/12", ""},
              {"exponential", "exactly by |dt omega| (eq 25); of backward Euler", ""}},
             "How an angular velocity turns a microrotation over a step.")
          .standard("cayley"),
      choice("point_rotations",
             {{"velocity", "they keep a history of their own, turned by interpolated angular velocities", ""},
              {"rotation-vectors", "mean of the nodes' rotation vectors", ""},
              {"quaternion-blend", "normalised mean of the nodes' quaternions", ""},
              {"spherical", "mean on the sphere (Buss and Fillmore)", ""}},
             "How microrotations at quadrature points come from those of the nodes, every reset_every steps.")
          .standard("velocity"),
      integer("reset_every", between(1, 1e9), "Steps between such resets, which end dependence on the path.")
          .standard(1),
      integer("checkpoint_every", between(0, 1e7), "Every so many frames a checkpoint is kept for good; 0: none.")
          .standard(24)
          .affects(Effect::nothing),
      integer("keep", between(1, 1000), "How many of the last checkpoints are kept besides.")
          .standard(2)
          .affects(Effect::nothing),
  };
  return section;
}

Section contact_section() {
  Section pair;
  pair.doc = "Friction of two materials; first and second may be the same.";
  pair.fields = {
      reference("first", "material", "The name of a material.").required(),
      reference("second", "material", "The name of a material.").required(),
      number("friction", "", at_least_zero(1e6), "Coulomb's coefficient at rest.").called("coefficient").required(),
      number("sliding_friction", "", at_least_zero(1e6), "The same while sliding.")
          .called("coefficient")
          .default_is("friction"),
  };
  Section section;
  section.doc = "Contact between bodies and within them; without this table bodies feel colliders only.";
  section.fields = {
      boolean("between", "Bodies push each other apart.").standard(true),
      boolean("within", "A body pushes itself apart where it folds.").standard(true),
      number("friction", "", at_least_zero(1e6), "Coulomb's coefficient at rest, of materials without a pair.")
          .called("coefficient")
          .standard(0.0),
      number("sliding_friction", "", at_least_zero(1e6), "The same while sliding.")
          .called("coefficient")
          .default_is("friction"),
      nested("pair", Kind::named_tables, pair, pair.doc),
  };
  return section;
}

} // namespace wry::shots
