#pragma once

#include <array>
#include <vector>

#include "sim/fem/fem_scene.h"
#include "sim/fem/fem_state.h"

namespace wry::fem {

/// Accelerations of nodes, zero where no motion gives them.
struct MotionOfNodes {
  Points linear;  ///< [m/s^2]
  Points angular; ///< [rad/s^2]
};

/// What holds nodes and drives them exactly: which unknowns are given in a step, and their values. Drives by springs
/// are an energy term.
class Boundary {
public:
  Boundary() = default;
  /// Copies what it needs.
  Boundary(const FemPlan& plan, const FemScene& scene);

  /// Marks the unknowns that are given in a step which ends at `time`.
  void hold(double time);
  /// Packed, nonzero: given.
  const std::vector<char>& held() const { return m_held; }
  /// Per node: nonzero when its position is given, so that no obstacle can push it.
  const std::vector<char>& immovable() const { return m_immovable; }

  /// Writes the given values into a trial; `rotations` are those that its increments start from, `positions` where the
  /// nodes are at the start of the step.
  void impose(const Stage& stage, const Quaternions& rotations, Trial& trial) const;

  /// The next time after `time` at which a hold ends or a motion has a corner, or `end`, whichever is first.
  double next_event(double time, double end) const;
  /// Of exactly driven nodes over the step of `dt` that ends at `time`: the change of their velocity by its length.
  MotionOfNodes accelerations(double time, double dt) const;
  /// The longest step from `time`, at most `dt`, in which no drive turns further than 30 degrees.
  double limit_step(double time, double dt) const;

private:
  struct Hold {
    std::vector<int> nodes;
    bool positions = true;
    std::array<bool, 3> axes = {true, true, true};  ///< of the positions
    std::array<bool, 3> turns = {true, true, true}; ///< components of the microrotations' increments
    double until = 0.0;                             ///< [s]; infinity: never released
    int motion = -1;                                ///< index into m_motions; -1: held where they are
  };

  bool active(const Hold& hold, double time) const;
  void add(const FemScene& scene, int body, const std::vector<std::int32_t>& vertices, Hold hold);
  void impose(const Hold& hold, const Stage& stage, const Quaternions& rotations, Trial& trial) const;

  std::vector<Hold> m_holds;
  std::vector<scene::Motion> m_motions; ///< of exact drives and of springs
  std::vector<double> m_events;         ///< ascending [s]
  DofLayout m_layout;
  Points m_rest;
  std::vector<char> m_held, m_immovable;
};

/// The springs of drives that are not exact. `elements` gives the stiffness of the matter around a node.
DriveSprings make_drive_springs(const FemPlan& plan, const FemScene& scene);

} // namespace wry::fem
