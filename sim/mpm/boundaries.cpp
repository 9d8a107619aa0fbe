#include "sim/mpm/boundaries.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/mpm/semi_implicit.h"

namespace wry::mpm {

namespace {

/// Nodes on the surface itself belong to the obstacle.
constexpr double ON_SURFACE = 1e-6; // cells

Vec3 node_position(const BlockCoord& coord, const Vec3& in_block, double cell) {
  return cell *
         (Vec3(static_cast<double>(coord.x), static_cast<double>(coord.y), static_cast<double>(coord.z)) * BLOCK_SIDE +
          in_block);
}

Result<scene::ColliderField> make_field(std::shared_ptr<const scene::Collider> collider, double cell) {
  return scene::ColliderField::create(std::move(collider),
                                      {0.5 * cell, LEAST_WALL_CELLS * cell, LEAST_SOLID_CELLS * cell});
}

/// A mesh exactly as it is drawn: what grains meet.
Result<std::optional<scene::ColliderField>> drawn_field(const std::shared_ptr<const scene::Collider>& collider,
                                                        double cell) {
  if (!std::holds_alternative<scene::MeshObstacle>(collider->shape))
    return std::optional<scene::ColliderField>();
  scene::ColliderFieldSettings settings;
  settings.voxel = 0.5 * cell;
  settings.closed_mesh = scene::MeshDistance::exact;
  Result<scene::ColliderField> field = scene::ColliderField::create(collider, settings);
  if (!field)
    return field.error();
  return std::optional<scene::ColliderField>(std::move(*field));
}

/// Whether a box has no wall there; side 0 is the lower one.
bool is_open(const scene::BoxObstacle& box, int axis, int side) {
  const int face = 2 * axis + side;
  return box.open[static_cast<std::size_t>(face)];
}

/// The walls of a container as solids that overlap where they meet, so that no wall has a face inside another one by
/// which a particle could find its way through. They grow outward to at least `least` [m].
std::vector<scene::BoxObstacle> overlapping_walls(const scene::BoxObstacle& box, double least) {
  const Vec3 half = 0.5 * box.size;
  const double thickness = std::max(box.wall, least);
  Vec3 outer[2]; // of the whole, by side
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const bool open = is_open(box, axis, side);
      outer[side][axis] = (side == 0 ? -1.0 : 1.0) * (open ? half[axis] : half[axis] - box.wall + thickness);
    }
  }
  std::vector<scene::BoxObstacle> walls;
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      if (is_open(box, axis, side))
        continue;
      Vec3 low = outer[0];
      Vec3 high = outer[1];
      (side == 0 ? high : low)[axis] = (side == 0 ? -1.0 : 1.0) * (half[axis] - box.wall);
      scene::BoxObstacle wall;
      wall.axes = box.axes;
      wall.centre = box.centre + box.axes * (0.5 * (low + high));
      wall.size = high - low;
      walls.push_back(wall);
    }
  }
  return walls;
}

/// What a collider is on the grid: itself, or the walls of a container one by one.
std::vector<std::shared_ptr<const scene::Collider>> obstacles_of(std::shared_ptr<const scene::Collider> collider,
                                                                 double cell) {
  const auto* box = std::get_if<scene::BoxObstacle>(&collider->shape);
  if (box == nullptr || !box->is_container())
    return {std::move(collider)};
  std::vector<std::shared_ptr<const scene::Collider>> walls;
  for (const scene::BoxObstacle& wall : overlapping_walls(*box, LEAST_WALL_CELLS * cell)) {
    auto one = std::make_shared<scene::Collider>(*collider);
    one->shape = wall;
    walls.push_back(std::move(one));
  }
  return walls;
}

/// Gathers what the contacts of a node leave of its freedom.
class Freedom {
public:
  /// A contact with this normal; `sticks`: nothing is left.
  void touch(const Vec3& normal, bool sticks) {
    constexpr double PARALLEL = 1e-3;
    const Vec3 edge = m_direction.cross(normal);
    if (sticks || (m_kind == Kind::along && std::abs(m_direction.dot(normal)) > PARALLEL)) {
      m_kind = Kind::all;
    } else if (m_kind == Kind::none) {
      m_kind = Kind::across;
      m_direction = normal;
    } else if (m_kind == Kind::across && edge.norm() > PARALLEL) {
      m_kind = Kind::along;
      m_direction = edge.normalized();
    }
  }
  bool is_whole() const { return m_kind == Kind::none; }
  NodeConstraint of(int node) const { return {node, m_kind, m_direction}; }

private:
  using Kind = NodeConstraint::Kind;
  Kind m_kind = Kind::none;
  Vec3 m_direction = Vec3::Zero();
};

} // namespace

Vec3 contact_velocity(const Vec3& velocity, const Vec3& wall, const Vec3& normal, scene::ColliderContact contact,
                      double friction) {
  if (contact == scene::ColliderContact::sticky)
    return wall;
  const Vec3 relative = velocity - wall;
  const double into = relative.dot(normal);
  if (contact == scene::ColliderContact::separate && into >= 0.0)
    return velocity;
  const Vec3 along = relative - into * normal;
  const double speed = along.norm();
  const double kept = speed > 0.0 ? std::max(0.0, 1.0 - friction * std::abs(into) / speed) : 0.0;
  return wall + kept * along;
}

Result<Boundaries> Boundaries::create(const MpmPlan& plan) {
  Boundaries made;
  made.m_cell = plan.settings.cell;
  const bool has_grains = std::any_of(plan.bodies.begin(), plan.bodies.end(),
                                      [](const MpmBody& body) { return body.sub_particles.has_value(); });
  for (const std::shared_ptr<const scene::Collider>& collider : plan.colliders) {
    for (const std::shared_ptr<const scene::Collider>& obstacle : obstacles_of(collider, made.m_cell)) {
      Result<scene::ColliderField> field = make_field(obstacle, made.m_cell);
      if (!field)
        return field.error();
      const bool is_plane = std::holds_alternative<scene::PlaneObstacle>(obstacle->shape);
      made.m_obstacles.push_back({std::move(*field), std::nullopt, {}, {}, !is_plane});
      if (!has_grains)
        continue;
      Result<std::optional<scene::ColliderField>> drawn = drawn_field(obstacle, made.m_cell);
      if (!drawn)
        return drawn.error();
      made.m_obstacles.back().drawn = std::move(*drawn);
    }
  }
  for (const HeldSpace& held : plan.held) {
    auto collider = std::make_shared<scene::Collider>();
    collider->name = held.name;
    collider->shape = held.shape;
    collider->motion = held.motion;
    collider->contact = scene::ColliderContact::sticky;
    Result<scene::ColliderField> field = make_field(collider, made.m_cell);
    if (!field)
      return field.error();
    made.m_held.push_back({{std::move(*field), std::nullopt, {}, {}, true}, held.until, true});
  }
  made.begin_step(0.0, 0.0);
  return made;
}

void Boundaries::begin_step(double time, double dt) {
  const auto place = [&](Obstacle& obstacle) {
    const scene::Motion& motion = obstacle.field.collider().motion;
    obstacle.pose = motion.pose(time + dt);
    obstacle.twist = motion.moves() ? motion.twist(time + 0.5 * dt) : scene::Twist{};
    obstacle.field.deform_to(time + dt);
    if (obstacle.drawn)
      obstacle.drawn->deform_to(time + dt);
  };
  for (Obstacle& obstacle : m_obstacles)
    place(obstacle);
  for (Held& held : m_held) {
    place(held.space);
    held.active = !held.until || time < *held.until * (1.0 - 1e-12);
  }
}

double Boundaries::max_speed(double time, double dt) const {
  double greatest = 0.0;
  double deforming = 0.0;
  const auto look = [&](const Obstacle& obstacle) {
    const scene::Collider& collider = obstacle.field.collider();
    if (const scene::MeshSequence* sequence = collider.sequence()) {
      for (const double at : {time, time + dt})
        deforming = std::max(deforming, std::sqrt(sequence->velocities_at(at).rowwise().squaredNorm().maxCoeff()));
    }
    if (!collider.motion.moves())
      return;
    const scene::ObstacleBounds bounds = scene::obstacle_bounds(collider.shape);
    for (const double at : {time, time + 0.5 * dt, time + dt}) {
      const scene::Twist twist = collider.motion.twist(at);
      const scene::Pose pose = collider.motion.pose(at);
      for (int corner = 0; corner < 8; ++corner) {
        Vec3 point;
        for (int axis = 0; axis < 3; ++axis)
          point[axis] = corner & (1 << axis) ? bounds.high[axis] : bounds.low[axis];
        const double speed = twist.at(pose.apply(point)).norm();
        greatest = std::max(greatest, std::isfinite(speed) ? speed : twist.linear.norm());
      }
    }
  };
  for (const Obstacle& obstacle : m_obstacles)
    look(obstacle);
  for (const Held& held : m_held) {
    if (held.active)
      look(held.space);
  }
  return greatest + deforming;
}

double Boundaries::clear_of_block(const Obstacle& obstacle, const BlockCoord& coord) const {
  constexpr double MIDDLE = 0.5 * (BLOCK_SIDE - 1);
  constexpr double MARGIN = 0.1; // cells
  const double distance = obstacle.field.distance(obstacle.pose, node_position(coord, Vec3::Constant(MIDDLE), m_cell));
  return distance - (MIDDLE * std::sqrt(3.0) + MARGIN) * m_cell;
}

template <class Scalar>
void Boundaries::constrain_nodes(const BlockCoord& coord, Scalar* values, std::vector<NodeConstraint>* found) const {
  // Nowhere within `clear` of the block's middle; most nodes of a block that an obstacle touches are further in.
  struct Near {
    const Obstacle* obstacle;
    double clear;
  };
  constexpr double MIDDLE = 0.5 * (BLOCK_SIDE - 1);
  const double surface = ON_SURFACE * m_cell;
  struct Touched {
    const Obstacle* obstacle;
    Vec3 normal, velocity;
  };
  std::vector<Near> near;
  std::vector<Touched> touched;
  for (const Obstacle& obstacle : m_obstacles) {
    const double clear = clear_of_block(obstacle, coord);
    if (clear <= 0.0)
      near.push_back({&obstacle, clear + MIDDLE * std::sqrt(3.0) * m_cell});
  }
  std::vector<const Obstacle*> holding;
  for (const Held& held : m_held) {
    if (held.active && clear_of_block(held.space, coord) <= 0.0)
      holding.push_back(&held.space);
  }
  if (near.empty() && holding.empty())
    return;
  for (int node = 0; node < BLOCK_VALUES / NODE_VALUES; ++node) {
    Scalar* value = values + node * NODE_VALUES;
    if (!(value[3] > 0))
      continue;
    const int plane = node / 16, row = node / 4 % 4;
    const Vec3 in_block(plane, row, node % 4);
    const Vec3 at = node_position(coord, in_block, m_cell);
    const double from_middle = (in_block - Vec3::Constant(MIDDLE)).norm() * m_cell;
    const Vec3 before(value[0], value[1], value[2]);
    Vec3 velocity = before;
    touched.clear();
    Freedom freedom;
    for (const auto& [obstacle, clear] : near) {
      if (from_middle < clear || obstacle->field.distance(obstacle->pose, at, 2.0 * surface) > surface)
        continue;
      const scene::ColliderSample sample = obstacle->field.sample(obstacle->pose, at);
      touched.push_back({obstacle, sample.normal, obstacle->twist.at(at) + sample.velocity});
    }
    // Corners: what one wall pushes into another is pushed out again.
    for (int round = touched.size() > 1 ? 2 : 1; round > 0; --round) {
      for (const auto& [obstacle, normal, wall] : touched) {
        const scene::Collider& collider = obstacle->field.collider();
        const Vec3 after = contact_velocity(velocity, wall, normal, collider.contact, collider.friction);
        if (found != nullptr && (after != velocity || collider.contact != scene::ColliderContact::separate))
          freedom.touch(normal, after == wall);
        velocity = after;
      }
    }
    for (const Obstacle* space : holding) {
      if (space->field.distance(space->pose, at, 2.0 * surface) > surface)
        continue;
      velocity = space->twist.at(at);
      freedom.touch(Vec3::Zero(), true);
    }
    if (found != nullptr && !freedom.is_whole())
      found->push_back(freedom.of(node));
    if (velocity == before)
      continue;
    for (int axis = 0; axis < 3; ++axis)
      value[axis] = static_cast<Scalar>(velocity[axis]);
  }
}

template void Boundaries::constrain_nodes(const BlockCoord&, float*, std::vector<NodeConstraint>*) const;
template void Boundaries::constrain_nodes(const BlockCoord&, double*, std::vector<NodeConstraint>*) const;

void Boundaries::walls_near(const BlockCoord& coord, std::vector<NearWall>& walls, WallKind kind) const {
  constexpr double MIDDLE = 0.5 * (BLOCK_SIDE - 1);
  // Particles reach 2.5 cells beyond the block's nodes before they are sorted, and move by less than one.
  constexpr double MARGIN = 6.0;
  const double reach = (MIDDLE * std::sqrt(3.0) + MARGIN) * m_cell;
  const Vec3 centre = node_position(coord, Vec3::Constant(MIDDLE), m_cell);
  constexpr double FAR = std::numeric_limits<double>::infinity();
  walls.clear();
  for (std::size_t i = 0; i < m_obstacles.size(); ++i) {
    if (!m_obstacles[i].has_inside && kind == WallKind::with_inside)
      continue;
    const Obstacle& obstacle = m_obstacles[i];
    const double distance = kind == WallKind::all ? obstacle.as_drawn().least_distance(obstacle.pose, centre, FAR)
                                                  : obstacle.field.distance(obstacle.pose, centre);
    if (distance <= reach)
      walls.push_back({static_cast<int>(i), centre, distance});
  }
}

Boundaries::WallsWithin Boundaries::walls_within(const std::vector<NearWall>& walls, const Vec3& point,
                                                 double reach) const {
  WallsWithin near{{}, reach};
  for (std::size_t i = 0; i < walls.size(); ++i) {
    if (!walls[i].may_touch(point, reach))
      continue;
    const Obstacle& obstacle = m_obstacles[static_cast<std::size_t>(walls[i].obstacle)];
    const double least = obstacle.as_drawn().least_distance(obstacle.pose, point, reach);
    if (least >= reach)
      continue;
    near.which.add(i);
    near.least_distance = std::min(near.least_distance, least);
  }
  return near;
}

std::optional<ObstacleContact> Boundaries::nearest_obstacle(const std::vector<NearWall>& walls, const Vec3& point,
                                                            double reach, WallSet among) const {
  std::optional<ObstacleContact> nearest;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    if (!among.has(i) || !walls[i].may_touch(point, reach))
      continue;
    const Obstacle& obstacle = m_obstacles[static_cast<std::size_t>(walls[i].obstacle)];
    const double wanted = nearest ? nearest->distance : reach;
    const scene::ColliderField& seen = obstacle.as_drawn();
    if (seen.least_distance(obstacle.pose, point, wanted) >= wanted)
      continue;
    const scene::ColliderSample sample = seen.sample(obstacle.pose, point);
    if (sample.distance < wanted)
      nearest = ObstacleContact{sample.distance, sample.normal, obstacle.twist.at(point) + sample.velocity};
  }
  return nearest;
}

bool Boundaries::push_out(const std::vector<NearWall>& walls, Vec3& position, Vec3& velocity) const {
  bool pushed = false;
  // Twice, since one wall of a corner may push into another.
  for (int round = 0; round < 2; ++round) {
    bool again = false;
    for (const NearWall& wall : walls) {
      const Obstacle& obstacle = m_obstacles[static_cast<std::size_t>(wall.obstacle)];
      if (!wall.may_touch(position, 0.0) || obstacle.field.distance(obstacle.pose, position, 0.0) >= 0.0)
        continue;
      const scene::ColliderSample sample = obstacle.field.sample(obstacle.pose, position);
      if (sample.distance >= 0.0)
        continue;
      position -= sample.distance * sample.normal;
      const double into = (velocity - obstacle.twist.at(position) - sample.velocity).dot(sample.normal);
      if (into < 0.0)
        velocity -= into * sample.normal;
      again = walls.size() > 1;
      pushed = true;
    }
    if (!again)
      break;
  }
  return pushed;
}

} // namespace wry::mpm
