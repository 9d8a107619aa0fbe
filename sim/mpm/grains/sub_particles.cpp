#include "sim/mpm/grains/sub_particles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <type_traits>

#include "sim/base/rotation.h"
#include "sim/mpm/grains/blue_noise.h"
#include "sim/mpm/grains/dice.h"
#include "sim/mpm/grains/flow_field.h"
#include "sim/mpm/grains/grid_snapshot.h"
#include "sim/mpm/matter/orientation.h"

namespace wry::mpm {

namespace {

constexpr int BLEND_UPDATES = 5;
/// Where the fringe of a pile is thinner than this share of capture_density, matter that lies still would hold grains
/// up to a cell and a half above it.
constexpr double FLOATING = 0.25;
constexpr double REST_SPEED = 0.03;   // [m/s] relative to what carries the grain
constexpr double LONGEST_TURN = 0.25; // dt |L| between updates
/// Cells that a flying grain may go in a part of an update, and how many parts there are at most.
constexpr double FURTHEST_FLIGHT = 0.5;
constexpr int MOST_PARTS = 64;

} // namespace

namespace {

/// A direction whose second moment is about diag(shares); exact when all shares are alike, or one is all.
Vec3 spread_direction(const Vec3& shares, Dice& dice) {
  if (shares == Vec3::UnitZ())
    return Vec3::UnitZ();
  Vec3 direction = Vec3::Zero();
  while (!(direction.norm() > 1e-9)) {
    for (int k = 0; k < 3; ++k)
      direction[k] = shares[k] * dice.normal(); // normalising draws towards the mean; shares, not their roots, make up
  }
  return direction.normalized();
}

/// The shortest turn of z to a direction.
Vec4 turn_to(const Vec3& direction) {
  if (direction.z() < -1.0 + 1e-12)
    return {0.0, 1.0, 0.0, 0.0};
  return Vec4(1.0 + direction.z(), -direction.y(), direction.x(), 0.0).normalized();
}

} // namespace

SubParticles::SubParticles(SubParticleSettings settings, const SubParticleStart& start)
    : m_settings(std::move(settings))
    , m_density(start.density) {
  const Points points =
      spread_in_particles(start.positions, start.particle_volume, m_settings.per_particle, m_settings.seed);
  const auto count = static_cast<std::size_t>(points.rows());
  m_position.resize(count);
  m_velocity.assign(count, start.velocity);
  m_spin.assign(count, Vec3::Zero());
  m_orientation.resize(count);
  m_state.assign(count, Phase::carried);
  m_blend.assign(count, 0);
  m_size.resize(count);
  Dice dice(m_settings.seed + 0x5EED);
  const double tilt = m_settings.tilt_degrees * std::numbers::pi / 180.0;
  for (std::size_t i = 0; i < count; ++i) {
    m_position[i] = points.row(static_cast<Eigen::Index>(i)).transpose();
    const Eigen::Index particle = static_cast<Eigen::Index>(i) / m_settings.per_particle;
    const Vec4 frame = start.frames.row(start.frames.rows() == 1 ? 0 : particle).transpose();
    const Vec4 roll = quaternion_exponential(2.0 * std::numbers::pi * dice.uniform() * Vec3::UnitZ());
    const Vec4 tilted = quaternion_exponential(Vec3(tilt * dice.normal(), tilt * dice.normal(), 0.0));
    const Vec4 spread = quaternion_product(turn_to(spread_direction(m_settings.second_moment, dice)), tilted);
    m_orientation[i] = quaternion_product(frame, quaternion_product(spread, roll));
    m_size[i] = static_cast<float>(std::clamp(1.0 + m_settings.size_variation * dice.normal(), 0.4, 2.0));
  }
}

/// Grains by block, blocks ascending, grains of a block in their own order: a stable counting sort. A block here stands
/// half a cell further than the grid's, so that grains may stray by three quarters of a cell before the next sort.
void SubParticles::sort(double cell) {
  BlockIndex found;
  std::vector<BlockCoord> coords;
  std::vector<std::int32_t> block_of(count());
  const double inverse = 1.0 / (cell * BLOCK_SIDE), shift = 0.5 / BLOCK_SIDE;
  BlockCoord last{std::numeric_limits<std::int64_t>::max(), 0, 0};
  std::int32_t last_block = 0;
  for (std::size_t i = 0; i < count(); ++i) {
    const auto along = [&](int axis) {
      return static_cast<std::int64_t>(std::floor(m_position[i][axis] * inverse - shift));
    };
    const BlockCoord coord{along(0), along(1), along(2)};
    if (coord != last) {
      const auto [place, is_new] = found.emplace(coord, static_cast<std::int32_t>(coords.size()));
      if (is_new)
        coords.push_back(coord);
      last = coord;
      last_block = place->second;
    }
    block_of[i] = last_block;
  }
  std::vector<std::int32_t> rank(coords.size()), by_coord(coords.size());
  std::iota(by_coord.begin(), by_coord.end(), 0);
  std::sort(by_coord.begin(), by_coord.end(), [&](std::int32_t a, std::int32_t b) {
    return coords[static_cast<std::size_t>(a)] < coords[static_cast<std::size_t>(b)];
  });
  m_runs.assign(coords.size(), {});
  for (std::size_t r = 0; r < by_coord.size(); ++r) {
    rank[static_cast<std::size_t>(by_coord[r])] = static_cast<std::int32_t>(r);
    m_runs[r].coord = coords[static_cast<std::size_t>(by_coord[r])];
  }
  for (std::int32_t& block : block_of) {
    block = rank[static_cast<std::size_t>(block)];
    ++m_runs[static_cast<std::size_t>(block)].end;
  }
  std::size_t before = 0;
  for (Run& run : m_runs) {
    const std::size_t size = run.end;
    run.begin = run.end = before;
    before += size;
  }
  m_order.resize(count());
  for (std::size_t i = 0; i < count(); ++i)
    m_order[m_runs[static_cast<std::size_t>(block_of[i])].end++] = static_cast<std::uint32_t>(i);
  m_strayed = false;
}

void SubParticles::leave_obstacles(const Boundaries& boundaries, double cell) {
  sort(cell);
  std::vector<NearWall> walls;
  for (const Run& run : m_runs) {
    boundaries.walls_near(run.coord, walls, WallKind::all);
    for (std::size_t i = run.begin; i < run.end; ++i) {
      const std::size_t grain = m_order[i];
      const double radius = 0.5 * m_settings.size.minCoeff() * static_cast<double>(m_size[grain]);
      for (int round = 0; round < 3; ++round) { // out of a corner, face by face
        const std::optional<ObstacleContact> met = boundaries.nearest_obstacle(walls, m_position[grain], radius);
        if (!met)
          break;
        m_position[grain] += (radius - met->distance) * met->normal;
      }
    }
  }
  m_strayed = true;
}

void SubParticles::meet_obstacles(std::size_t grain, const FlowField& field) {
  if (field.walls.empty())
    return;
  // Half the thinnest extent: a grain that lies flat just touches.
  const double radius = 0.5 * m_settings.size.minCoeff() * static_cast<double>(m_size[grain]);
  Vec3& position = m_position[grain];
  const std::optional<ObstacleContact> met = field.boundaries->nearest_obstacle(field.walls, position, radius);
  if (!met)
    return;
  const ObstacleContact& contact = *met;
  position += (radius - contact.distance) * contact.normal;
  // What one obstacle pushes into another is pushed out of that.
  for (int round = 0; round < 2; ++round) {
    const std::optional<ObstacleContact> inside = field.boundaries->nearest_obstacle(field.walls, position, 0.0);
    if (!inside)
      break;
    position += (0.5 * radius - inside->distance) * inside->normal;
  }
  if (m_state[grain] == Phase::carried)
    return;
  Vec3& velocity = m_velocity[grain];
  Vec3 relative = velocity - contact.velocity;
  const double into = relative.dot(contact.normal);
  if (into < 0.0) {
    const Vec3 along = relative - into * contact.normal;
    const double speed = along.norm();
    const double kept =
        speed > 0.0 ? std::max(0.0, 1.0 - m_settings.friction * (1.0 + m_settings.restitution) * -into / speed) : 0.0;
    relative = kept * along - m_settings.restitution * into * contact.normal;
    velocity = contact.velocity + relative;
    m_spin[grain] *= 0.5;
  }
  // Lie down: the thinnest axis turns towards the normal, a rod's length away from it.
  const Mat3 R = rotation_matrix(m_orientation[grain]);
  Eigen::Index thin = 0, longest = 0;
  m_settings.size.minCoeff(&thin);
  m_settings.size.maxCoeff(&longest);
  const bool is_rod = m_settings.size[longest] > 2.0 * m_settings.size[3 - thin - longest];
  Vec3 torque;
  if (is_rod) {
    const Vec3 axis = R.col(longest);
    torque = axis.cross(axis - axis.dot(contact.normal) * contact.normal);
  } else {
    const Vec3 axis = R.col(thin);
    torque = axis.cross(axis.dot(contact.normal) < 0.0 ? Vec3(-contact.normal) : contact.normal);
  }
  const double share = 1.0 - std::exp(-25.0 * field.dt);
  m_orientation[grain] = quaternion_product(quaternion_exponential(share * torque), m_orientation[grain]).normalized();
  const bool holds = contact.normal.dot(field.gravity) < 0.0 &&
                     (field.gravity - field.gravity.dot(contact.normal) * contact.normal).norm() <=
                         m_settings.friction * -field.gravity.dot(contact.normal);
  if (relative.norm() < REST_SPEED && holds && torque.norm() < 0.1) {
    m_state[grain] = Phase::resting;
    m_spin[grain].setZero();
  }
}

namespace {

/// The rotation nearest to I + dt C for small dt C, as a quaternion: Newton's iteration, each squaring the error.
Vec4 small_turn(const Mat3& C, double dt) {
  Mat3 R = Mat3::Identity() + dt * C;
  double error = dt * C.norm();
  for (int i = 0; i < 6 && error > 1e-7; ++i, error *= error) { // the velocities have seven digits
    Mat3 cofactors;
    cofactors.row(0) = R.row(1).cross(R.row(2));
    cofactors.row(1) = R.row(2).cross(R.row(0));
    cofactors.row(2) = R.row(0).cross(R.row(1));
    R = 0.5 * R + (0.5 / R.row(0).dot(cofactors.row(0))) * cofactors;
  }
  return Vec4(1.0 + R.trace(), R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
}

} // namespace

/// Thinner matter carries no grain.
double SubParticles::thinnest() const {
  return std::max(m_settings.escape_density, FLOATING * m_settings.capture_density);
}

/// RK2: the midpoint is predicted with the velocity of the midpoint before, which leaves the order and saves half of
/// the interpolation. Returns whether there is matter to be carried by.
bool SubParticles::carry(std::size_t grain, const FlowField& field) {
  Vec3& position = m_position[grain];
  Vec3 middle;
  Mat3 gradient;
  if (!field.motion_at(position + 0.5 * field.dt * m_velocity[grain], thinnest(), middle, gradient))
    return false;
  if (m_blend[grain] > 0) {
    const double own = static_cast<double>(m_blend[grain]--) / (BLEND_UPDATES + 1);
    middle = own * m_velocity[grain] + (1.0 - own) * middle;
  }
  position += field.dt * middle;
  m_velocity[grain] = middle;
  m_spin[grain] =
      0.5 * Vec3(gradient(2, 1) - gradient(1, 2), gradient(0, 2) - gradient(2, 0), gradient(1, 0) - gradient(0, 1));
  Vec4& orientation = m_orientation[grain];
  if (!m_settings.jeffery) {
    orientation = quaternion_product(small_turn(gradient, field.dt), orientation).normalized();
    return true;
  }
  const Vec3 before = rotation_matrix(orientation).col(2);
  const Vec4 turned = quaternion_product(quaternion_exponential(field.dt * m_spin[grain]), orientation);
  const Vec3 dragged = rotation_matrix(turned).col(2);
  const Vec3 wanted = turn_direction(before, gradient, *m_settings.jeffery, field.dt);
  const Vec3 axis = dragged.cross(wanted);
  const double sine = axis.norm();
  const Vec3 rest = sine > 1e-12 ? Vec3(std::atan2(sine, dragged.dot(wanted)) / sine * axis) : Vec3(Vec3::Zero());
  orientation = quaternion_product(quaternion_exponential(rest), turned).normalized();
  return true;
}

void SubParticles::fly(std::size_t grain, const FlowField& field) {
  m_velocity[grain] += field.dt * field.gravity;
  m_position[grain] += field.dt * m_velocity[grain];
  m_orientation[grain] =
      quaternion_product(quaternion_exponential(field.dt * m_spin[grain]), m_orientation[grain]).normalized();
}

/// What carries a resting grain; it flies again when that moves or is gone.
bool SubParticles::rest(std::size_t grain, const FlowField& field) {
  const std::optional<ObstacleContact> carrier =
      field.walls.empty()
          ? std::nullopt
          : field.boundaries->nearest_obstacle(field.walls, m_position[grain], m_settings.size.maxCoeff());
  m_velocity[grain] = carrier ? carrier->velocity : Vec3(Vec3::Zero());
  return carrier && carrier->velocity.norm() < 1e-9;
}

/// Returns whether a grain has strayed too far from the block.
bool SubParticles::update_run(const Run& run, const FlowField& field) {
  constexpr double FURTHEST = 0.2; // of the sorted block; an update adds at most half a cell
  const double capture = std::max(m_settings.capture_density, 2.0 * m_settings.escape_density);
  const double inverse = 1.0 / field.cell;
  bool strayed = false;
  constexpr std::size_t AHEAD = 6;
  for (std::size_t i = run.begin; i < run.end; ++i) {
    if (i + AHEAD < run.end) { // grains of a block lie apart in memory
      const std::size_t next = m_order[i + AHEAD];
      __builtin_prefetch(&m_position[next], 1);
      __builtin_prefetch(&m_velocity[next], 1);
      __builtin_prefetch(&m_spin[next], 1);
      __builtin_prefetch(&m_orientation[next], 1);
    }
    const std::size_t grain = m_order[i];
    Phase& phase = m_state[grain];
    if (phase != Phase::carried && field.density_at(m_position[grain]) > capture) {
      phase = Phase::carried;
      m_blend[grain] = BLEND_UPDATES;
    }
    if (phase == Phase::resting && rest(grain, field))
      continue;
    if (phase != Phase::carried || !carry(grain, field)) {
      phase = Phase::flying;
      fly(grain, field);
    }
    meet_obstacles(grain, field);
    const Vec3 local = m_position[grain] * inverse - field.origin;
    strayed |= local.minCoeff() < 0.5 - FURTHEST || local.maxCoeff() > BLOCK_SIDE + 0.5 + FURTHEST;
  }
  return strayed;
}

double SubParticles::due(const StepSeen& step, const Vec3& gravity, double cell) {
  m_pending += step.dt;
  double speed = step.max_speed;
  if (m_settings.clock == GrainClock::matter_and_grains)
    speed = std::max(speed, m_fastest + m_pending * gravity.norm());
  m_gone += step.dt * speed / cell;
  m_turned += step.dt * step.max_gradient;
  if (!step.ends_frame && m_gone < m_settings.travel && m_turned < LONGEST_TURN)
    return 0.0;
  const double span = m_pending;
  m_pending = m_gone = m_turned = 0.0;
  return span;
}

template <class AnyGrid>
void SubParticles::update(const AnyGrid& grid, const Boundaries& boundaries, const Vec3& gravity, double cell,
                          double span, const Threads& threads) {
  int parts = 1;
  if (m_settings.clock == GrainClock::matter) { // which does not know how far those that fly may go
    const double furthest = span * (m_fastest + span * gravity.norm()) / cell;
    parts = std::clamp(static_cast<int>(std::ceil(furthest / FURTHEST_FLIGHT)), 1, MOST_PARTS);
  }
  BlockIndex blocks;
  blocks.reserve(grid.block_count());
  for (std::size_t b = 0; b < grid.block_count(); ++b)
    blocks.emplace(grid.coord(b), static_cast<std::int32_t>(b));
  for (int part = 0; part < parts; ++part)
    advance(grid, blocks, boundaries, gravity, cell, span / parts, threads);
  ++m_updates;
}

namespace {

/// What a block's grains may need of a grid: nodes around it, as they are read from its neighbours.
template <class AnyGrid>
void read_nodes(const AnyGrid& grid, const BlockIndex& blocks, double mass_of_full_cell, double least_share,
                FlowField& field) {
  using Scalar = std::remove_cvref_t<decltype(*grid.values(0))>;
  const Scalar* near[27];
  for (int n = 0; n < 27; ++n) {
    const auto found =
        blocks.find({field.coord.x + n / 9 - 1, field.coord.y + n / 3 % 3 - 1, field.coord.z + n % 3 - 1});
    near[n] = found == blocks.end() ? nullptr : grid.values(static_cast<std::size_t>(found->second));
  }
  constexpr int SIDE = FlowField::SIDE;
  for (int node = 0; node < FlowField::NODES; ++node) {
    const int at[3] = {node / (SIDE * SIDE) - 1, node / SIDE % SIDE - 1, node % SIDE - 1};
    int block = 0, place = 0;
    for (const int k : at) {
      block = block * 3 + (k + BLOCK_SIDE) / BLOCK_SIDE;
      place = place * BLOCK_SIDE + (k + BLOCK_SIDE) % BLOCK_SIDE;
    }
    const Scalar* value = near[block] == nullptr ? nullptr : near[block] + place * NODE_VALUES;
    // Through a float, as a snapshot of the grid has it.
    const double share = value == nullptr ? 0.0 : static_cast<double>(static_cast<float>(value[3])) / mass_of_full_cell;
    field.density[node] = static_cast<float>(share);
    field.flow[node] = share >= least_share ? Quad{static_cast<float>(value[0]), static_cast<float>(value[1]),
                                                   static_cast<float>(value[2]), 1.0F}
                                            : Quad{};
  }
  field.least_density = *std::min_element(field.density, field.density + FlowField::NODES);
}

} // namespace

/// All grains by so long.
template <class AnyGrid>
void SubParticles::advance(const AnyGrid& grid, const BlockIndex& blocks, const Boundaries& boundaries,
                           const Vec3& gravity, double cell, double dt, const Threads& threads) {
  if (m_strayed)
    sort(cell);
  std::vector<double> fastest(m_runs.size(), 0.0);
  std::vector<char> strayed(m_runs.size(), 0);
  threads.for_each(m_runs.size(), 1, [&](std::size_t r) {
    const Run& run = m_runs[r];
    FlowField field;
    field.coord = run.coord;
    field.origin =
        Vec3(static_cast<double>(run.coord.x), static_cast<double>(run.coord.y), static_cast<double>(run.coord.z)) *
        BLOCK_SIDE;
    field.boundaries = &boundaries;
    field.gravity = gravity;
    field.cell = cell;
    field.dt = dt;
    boundaries.walls_near(run.coord, field.walls, WallKind::all);
    read_nodes(grid, blocks, m_density * cell * cell * cell, m_settings.escape_density, field);
    strayed[r] = update_run(run, field) ? 1 : 0;
    for (std::size_t i = run.begin; i < run.end; ++i) {
      if (m_state[m_order[i]] == Phase::flying)
        fastest[r] = std::max(fastest[r], m_velocity[m_order[i]].norm());
    }
  });
  m_fastest = fastest.empty() ? 0.0 : *std::max_element(fastest.begin(), fastest.end());
  m_strayed = std::find(strayed.begin(), strayed.end(), 1) != strayed.end();
}

#define WRY_INSTANTIATE(AnyGrid)                                                                                       \
  template void SubParticles::update(const AnyGrid&, const Boundaries&, const Vec3&, double, double, const Threads&);
WRY_INSTANTIATE(Grid<float>)
WRY_INSTANTIATE(Grid<double>)
WRY_INSTANTIATE(SnapshotGrid)
#undef WRY_INSTANTIATE

} // namespace wry::mpm
