#pragma once

#include <optional>
#include <vector>

#include "sim/base/result.h"
#include "sim/mpm/grid.h"
#include "sim/mpm/mpm_plan.h"
#include "sim/scene/collider_field.h"

namespace wry::mpm {

/// Walls count as at least this many cells thick: matter on both sides of a thinner one would feel each other through
/// the grid, and could pass.
inline constexpr double LEAST_WALL_CELLS = 2.0;

/// What is thinner in a closed mesh counts as this many cells, growing on both sides: a node of the grid is then in it
/// wherever it stands.
inline constexpr double LEAST_SOLID_CELLS = 1.5;

struct NodeConstraint;

/// What a point near an obstacle sees.
struct ObstacleContact {
  double distance = 0.0;        ///< [m], negative inside
  Vec3 normal = Vec3::UnitY();  ///< away from the obstacle
  Vec3 velocity = Vec3::Zero(); ///< of the obstacle's matter there [m/s]
};

/// An obstacle near a block. It is nowhere within `clear` of `centre`, so that most points need no distance of their
/// own: one of a mesh costs a microsecond.
struct NearWall {
  int obstacle = 0;
  Vec3 centre = Vec3::Zero(); ///< of the block [m]
  double clear = 0.0;         ///< [m]

  /// Whether a point may be nearer to the obstacle than `reach` [m].
  bool may_touch(const Vec3& point, double reach) const {
    const double left = clear - reach;
    return left <= 0.0 || (point - centre).squaredNorm() > left * left;
  }
};

/// Some of a block's walls, by their place; those beyond the 31st together.
class WallSet {
public:
  WallSet() = default; ///< none
  static WallSet all() {
    WallSet set;
    set.m_bits = ~0U;
    return set;
  }
  void add(std::size_t wall) { m_bits |= bit(wall); }
  bool has(std::size_t wall) const { return (m_bits & bit(wall)) != 0; }
  bool is_empty() const { return m_bits == 0; }

private:
  static std::uint32_t bit(std::size_t wall) { return 1U << (wall < 31 ? wall : 31); }
  std::uint32_t m_bits = 0;
};

/// Which obstacles count as walls: those that particles can get through, as the grid has them; or planes too, and all
/// as they are drawn.
enum class WallKind { with_inside, all };

/// Obstacles and prescribed velocities on the grid, and what keeps particles out of walls.
class Boundaries {
public:
  /// Errors: those of the obstacles' distance fields.
  static Result<Boundaries> create(const MpmPlan& plan);

  /// For a step from `time` to time + dt.
  void begin_step(double time, double dt);
  /// Greatest speed of an obstacle within its bounds, between these times [m/s].
  double max_speed(double time, double dt) const;

  /// Velocities of a block's nodes with mass, in place. `found`, unless it is nullptr, is told what contact leaves of
  /// the nodes' freedom: a node that slides keeps its velocity along the normal, one that sticks all of it.
  template <class Scalar>
  void constrain_nodes(const BlockCoord& coord, Scalar* values, std::vector<NodeConstraint>* found = nullptr) const;

  /// Which obstacles a particle of this block may be in at the end of the step; by index, ascending.
  void walls_near(const BlockCoord& coord, std::vector<NearWall>& walls, WallKind kind = WallKind::with_inside) const;
  /// Puts a particle back to the surface of the walls it is in and takes away the velocity into them. Returns whether
  /// it had to.
  bool push_out(const std::vector<NearWall>& walls, Vec3& position, Vec3& velocity) const;
  /// Which of a block's walls a point may be nearer to than `reach` [m] as they are drawn: none that is nearer is left
  /// out. And how near any may be.
  struct WallsWithin {
    WallSet which;
    double least_distance = 0.0; ///< [m]; of no wall: without meaning
  };
  WallsWithin walls_within(const std::vector<NearWall>& walls, const Vec3& point, double reach) const;
  /// The wall, of `among`, that is nearest to a point as it is drawn, if one is nearer than `reach` [m].
  std::optional<ObstacleContact> nearest_obstacle(const std::vector<NearWall>& walls, const Vec3& point, double reach,
                                                  WallSet among = WallSet::all()) const;

private:
  struct Obstacle {
    scene::ColliderField field;
    std::optional<scene::ColliderField> drawn; ///< a mesh itself, where there are grains to meet it
    scene::Pose pose;
    scene::Twist twist;
    bool has_inside = true; ///< planes end the world: no particle gets through

    const scene::ColliderField& as_drawn() const { return drawn ? *drawn : field; }
  };
  struct Held {
    Obstacle space;
    std::optional<double> until;
    bool active = true;
  };
  /// How far an obstacle keeps from a block's nodes [m], less than a tenth of a cell wrong; negative: it may touch
  /// them.
  double clear_of_block(const Obstacle& obstacle, const BlockCoord& coord) const;

  double m_cell = 0.0;
  std::vector<Obstacle> m_obstacles;
  std::vector<Held> m_held;
};

/// The velocity of matter at an obstacle that moves with `wall`, by its contact and Coulomb friction (spec S6).
Vec3 contact_velocity(const Vec3& velocity, const Vec3& wall, const Vec3& normal, scene::ColliderContact contact,
                      double friction);

} // namespace wry::mpm
