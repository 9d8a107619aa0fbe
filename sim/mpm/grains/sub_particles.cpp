#include "sim/mpm/grains/sub_particles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <type_traits>
#include <utility>

#include "sim/base/rotation.h"
#include "sim/mpm/grains/blue_noise.h"
#include "sim/mpm/grains/dice.h"
#include "sim/mpm/grains/flow_field.h"
#include "sim/mpm/grains/grain_kernels.h"
#include "sim/mpm/grains/grid_snapshot.h"
#include "sim/mpm/kernels/transfer_table.h"

namespace wry::mpm {

namespace {

constexpr int BLEND_UPDATES = 5;
/// Where the fringe of a pile is thinner than this share of capture_density, matter that lies still would hold grains
/// up to a cell and a half above it.
constexpr double FLOATING = 0.25;
/// Of a grain beside its body's own.
constexpr double LEAST_SIZE = 0.4, GREATEST_SIZE = 2.0;
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

SubParticles::SubParticles(SubParticleSettings settings, const SubParticleStart& start, Isa isa)
    : m_settings(std::move(settings))
    , m_isa(isa)
    , m_kernels(&grain_kernels(isa))
    , m_density(start.density) {
  const Points points =
      spread_in_particles(start.positions, start.particle_volume, m_settings.per_particle, m_settings.seed);
  const auto count = static_cast<std::size_t>(points.rows());
  m_grains.resize(count);
  m_state.assign(count, Phase::carried);
  m_blend.assign(count, 0);
  m_size.resize(count);
  Dice dice(m_settings.seed + 0x5EED);
  const double tilt = m_settings.tilt_degrees * std::numbers::pi / 180.0;
  for (std::size_t i = 0; i < count; ++i) {
    m_grains[i].position = points.row(static_cast<Eigen::Index>(i)).transpose();
    m_grains[i].velocity = start.velocity;
    m_grains[i].spin.setZero();
    const Eigen::Index particle = static_cast<Eigen::Index>(i) / m_settings.per_particle;
    const Vec4 frame = start.frames.row(start.frames.rows() == 1 ? 0 : particle).transpose();
    const Vec4 roll = quaternion_exponential(2.0 * std::numbers::pi * dice.uniform() * Vec3::UnitZ());
    const Vec4 tilted = quaternion_exponential(Vec3(tilt * dice.normal(), tilt * dice.normal(), 0.0));
    const Vec4 spread = quaternion_product(turn_to(spread_direction(m_settings.second_moment, dice)), tilted);
    m_grains[i].orientation = quaternion_product(frame, quaternion_product(spread, roll));
    m_size[i] =
        static_cast<float>(std::clamp(1.0 + m_settings.size_variation * dice.normal(), LEAST_SIZE, GREATEST_SIZE));
  }
}

/// Grains by block, blocks ascending, grains of a block in their own order: as they lie in memory. A block here stands
/// half a cell further than the grid's, so that grains may stray by three quarters of a cell before the next sort.
void SubParticles::sort(double cell) {
  BlockIndex found;
  std::vector<BlockCoord> coords;
  std::vector<std::uint32_t> block_of(count());
  const double inverse = 1.0 / (cell * BLOCK_SIDE), shift = 0.5 / BLOCK_SIDE;
  // The blocks that were met last, since grains of a few lie mixed in memory.
  struct Met {
    BlockCoord coord{std::numeric_limits<std::int64_t>::max(), 0, 0};
    std::uint32_t block = 0;
  };
  std::array<Met, 64> met;
  for (std::size_t i = 0; i < count(); ++i) {
    const auto along = [&](int axis) {
      return static_cast<std::int64_t>(std::floor(m_grains[i].position[axis] * inverse - shift));
    };
    const BlockCoord coord{along(0), along(1), along(2)};
    Met& last = met[static_cast<std::size_t>((coord.x & 3) * 16 + (coord.y & 3) * 4 + (coord.z & 3))];
    if (coord != last.coord) {
      const auto [place, is_new] = found.emplace(coord, static_cast<std::int32_t>(coords.size()));
      if (is_new)
        coords.push_back(coord);
      last = {coord, static_cast<std::uint32_t>(place->second)};
    }
    block_of[i] = last.block;
  }
  std::vector<std::uint32_t> by_coord(coords.size());
  std::iota(by_coord.begin(), by_coord.end(), 0U);
  std::sort(by_coord.begin(), by_coord.end(), [&](std::uint32_t a, std::uint32_t b) { return coords[a] < coords[b]; });
  std::vector<std::uint32_t> end(coords.size(), 0U);
  for (const std::uint32_t block : block_of)
    ++end[block];
  m_runs.resize(coords.size());
  std::uint32_t before = 0;
  for (std::size_t r = 0; r < by_coord.size(); ++r) {
    m_runs[r] = {coords[by_coord[r]], before, before + end[by_coord[r]]};
    before += std::exchange(end[by_coord[r]], before);
  }
  m_order.resize(count());
  for (std::size_t i = 0; i < count(); ++i)
    m_order[end[block_of[i]]++] = static_cast<std::uint32_t>(i);
  m_strayed = false;
}

/// Half the thinnest extent: a grain that lies flat just touches.
double SubParticles::radius_of(double size) const {
  return 0.5 * m_settings.size.minCoeff() * size;
}

void SubParticles::leave_obstacles(const Boundaries& boundaries, double cell) {
  sort(cell);
  std::vector<NearWall> walls;
  for (const Run& run : m_runs) {
    boundaries.walls_near(run.coord, walls, WallKind::all);
    for (std::size_t i = run.begin; i < run.end; ++i) {
      const std::size_t grain = m_order[i];
      const double radius = radius_of(static_cast<double>(m_size[grain]));
      for (int round = 0; round < 3; ++round) { // out of a corner, face by face
        const std::optional<ObstacleContact> met = boundaries.nearest_obstacle(walls, m_grains[grain].position, radius);
        if (!met)
          break;
        m_grains[grain].position += (radius - met->distance) * met->normal;
      }
    }
  }
  m_strayed = true;
}

void SubParticles::meet_obstacles(std::size_t grain, const FlowField& field, WallSet among) {
  const double radius = radius_of(static_cast<double>(m_size[grain]));
  Vec3& position = m_grains[grain].position;
  const std::optional<ObstacleContact> met = field.boundaries->nearest_obstacle(field.walls, position, radius, among);
  if (!met)
    return;
  const ObstacleContact& contact = *met;
  position += (radius - contact.distance) * contact.normal;
  // What one obstacle pushes into another is pushed out of that; one from outside only into what it could reach before.
  if (contact.distance < 0.0)
    among = WallSet::all();
  for (int round = 0; round < 2; ++round) {
    const std::optional<ObstacleContact> inside = field.boundaries->nearest_obstacle(field.walls, position, 0.0, among);
    if (!inside)
      break;
    position += (0.5 * radius - inside->distance) * inside->normal;
    among = WallSet::all();
  }
  if (m_state[grain] == Phase::carried)
    return;
  Vec3& velocity = m_grains[grain].velocity;
  Vec3 relative = velocity - contact.velocity;
  const double into = relative.dot(contact.normal);
  if (into < 0.0) {
    const Vec3 along = relative - into * contact.normal;
    const double speed = along.norm();
    const double kept =
        speed > 0.0 ? std::max(0.0, 1.0 - m_settings.friction * (1.0 + m_settings.restitution) * -into / speed) : 0.0;
    relative = kept * along - m_settings.restitution * into * contact.normal;
    velocity = contact.velocity + relative;
    m_grains[grain].spin *= 0.5;
  }
  // Lie down: the thinnest axis turns towards the normal, a rod's length away from it.
  const Mat3 R = rotation_matrix(m_grains[grain].orientation);
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
  m_grains[grain].orientation =
      quaternion_product(quaternion_exponential(share * torque), m_grains[grain].orientation).normalized();
  const bool holds = contact.normal.dot(field.gravity) < 0.0 &&
                     (field.gravity - field.gravity.dot(contact.normal) * contact.normal).norm() <=
                         m_settings.friction * -field.gravity.dot(contact.normal);
  if (relative.norm() < REST_SPEED && holds && torque.norm() < 0.1) {
    m_state[grain] = Phase::resting;
    m_grains[grain].spin.setZero();
  }
}

/// Thinner matter carries no grain.
double SubParticles::thinnest() const {
  return std::max(m_settings.escape_density, FLOATING * m_settings.capture_density);
}

/// Those of a batch are carried; the rest flies.
void SubParticles::carry(const std::uint32_t* grains, int count, const FlowField& field) {
  GrainBatch batch;
  for (int lane = 0; lane < count; ++lane) {
    const std::size_t grain = grains[lane];
    const Grain& from = m_grains[grain];
    for (int k = 0; k < 3; ++k) {
      batch.position[k][lane] = from.position[k];
      batch.velocity[k][lane] = from.velocity[k];
    }
    for (int k = 0; k < 4; ++k)
      batch.orientation[k][lane] = from.orientation[k];
    batch.own[lane] = static_cast<double>(m_blend[grain]) / (BLEND_UPDATES + 1);
  }
  GrainMotion motion;
  motion.dt = field.dt;
  motion.thinnest = thinnest();
  motion.turns_by_flow = m_settings.jeffery.has_value();
  motion.jeffery = m_settings.jeffery.value_or(0.0);
  m_kernels->carry(field.nodes, motion, count, batch);
  for (int lane = 0; lane < count; ++lane) {
    const std::size_t grain = grains[lane];
    if (!batch.carried[lane]) {
      m_state[grain] = Phase::flying;
      fly(grain, field);
      continue;
    }
    Grain& to = m_grains[grain];
    for (int k = 0; k < 3; ++k) {
      to.position[k] = batch.position[k][lane];
      to.velocity[k] = batch.velocity[k][lane];
      to.spin[k] = batch.spin[k][lane];
    }
    for (int k = 0; k < 4; ++k)
      to.orientation[k] = batch.orientation[k][lane];
    if (m_blend[grain] > 0)
      --m_blend[grain];
  }
}

void SubParticles::fly(std::size_t grain, const FlowField& field) {
  m_grains[grain].velocity += field.dt * field.gravity;
  m_grains[grain].position += field.dt * m_grains[grain].velocity;
  m_grains[grain].orientation =
      quaternion_product(quaternion_exponential(field.dt * m_grains[grain].spin), m_grains[grain].orientation)
          .normalized();
}

/// What carries a resting grain; it flies again when that moves or is gone.
bool SubParticles::rest(std::size_t grain, const FlowField& field) {
  const std::optional<ObstacleContact> carrier =
      field.walls.empty()
          ? std::nullopt
          : field.boundaries->nearest_obstacle(field.walls, m_grains[grain].position, m_settings.size.maxCoeff());
  m_grains[grain].velocity = carrier ? carrier->velocity : Vec3(Vec3::Zero());
  return carrier && carrier->velocity.norm() < 1e-9;
}

SubParticles::RunReport SubParticles::update_run(const Run& run, FlowField& field) {
  // Out of the sorted block: the next update must not lead the middle of a grain's way out of the halo, which is a cell
  // wider. It goes about as far as `travel`, or half a cell where grains fly.
  const double furthest = std::max(0.2, 0.7 - m_settings.travel);
  const double capture = std::max(m_settings.capture_density, 2.0 * m_settings.escape_density);
  const double inverse = 1.0 / field.nodes.cell;
  const Vec3 origin = field.origin();
  RunReport report;
  std::uint32_t carried[GRAINS_AT_ONCE];
  int carried_count = 0;
  const auto finish = [&](std::uint32_t grain) {
    Vec3 local = m_grains[grain].position * inverse - origin;
    if (const WallSet near = field.walls_at(local, radius_of(static_cast<double>(m_size[grain]))); !near.is_empty()) {
      meet_obstacles(grain, field, near);
      local = m_grains[grain].position * inverse - origin;
    }
    report.strayed |= local.minCoeff() < 0.5 - furthest || local.maxCoeff() > BLOCK_SIDE + 0.5 + furthest;
    if (m_state[grain] == Phase::flying)
      report.fastest = std::max(report.fastest, m_grains[grain].velocity.norm());
  };
  constexpr std::size_t AHEAD = GRAINS_AT_ONCE;
  for (std::size_t i = run.begin; i < run.end; ++i) {
    if (i + AHEAD < run.end) { // grains of a block lie apart in memory
      const char* next = reinterpret_cast<const char*>(&m_grains[m_order[i + AHEAD]]);
      __builtin_prefetch(next, 1);
      __builtin_prefetch(next + 64, 1);
    }
    const std::uint32_t grain = m_order[i];
    Phase& phase = m_state[grain];
    if (phase != Phase::carried && field.density_at(m_grains[grain].position) > capture) {
      phase = Phase::carried;
      m_blend[grain] = BLEND_UPDATES;
    }
    if (phase == Phase::carried) {
      carried[carried_count++] = grain;
    } else if (phase == Phase::flying || !rest(grain, field)) {
      phase = Phase::flying;
      fly(grain, field);
      finish(grain);
    }
    if (carried_count == GRAINS_AT_ONCE || (carried_count > 0 && i + 1 == run.end)) {
      carry(carried, carried_count, field);
      std::for_each(carried, carried + carried_count, finish);
      carried_count = 0;
    }
  }
  return report;
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
std::size_t SubParticles::update(const AnyGrid& grid, const Boundaries& boundaries, const Vec3& gravity, double cell,
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
  return count() * static_cast<std::size_t>(parts);
}

namespace {

/// The nodes around a block; where the grid has none, there is no matter.
template <class AnyGrid>
void read_halo(const AnyGrid& grid, const BlockIndex& blocks, const BlockCoord& at, Isa isa,
               std::remove_cvref_t<decltype(*grid.values(0))>* halo) {
  using Scalar = std::remove_cvref_t<decltype(*grid.values(0))>;
  alignas(64) static constexpr Scalar NOTHING[BLOCK_VALUES] = {};
  const Scalar* near[NEIGHBOURS];
  for (int n = 0; n < NEIGHBOURS; ++n) {
    const auto found = blocks.find({at.x + n / 9 - 1, at.y + n / 3 % 3 - 1, at.z + n % 3 - 1});
    near[n] = found == blocks.end() ? NOTHING : grid.values(static_cast<std::size_t>(found->second));
  }
  transfer_kernels<Scalar>(isa).read_halo(near, halo);
}

} // namespace

/// All grains by so long.
template <class AnyGrid>
void SubParticles::advance(const AnyGrid& grid, const BlockIndex& blocks, const Boundaries& boundaries,
                           const Vec3& gravity, double cell, double dt, const Threads& threads) {
  if (m_strayed)
    sort(cell);
  using Scalar = std::remove_cvref_t<decltype(*grid.values(0))>;
  std::vector<RunReport> reports(m_runs.size());
  threads.for_each(m_runs.size(), 1, [&](std::size_t r) {
    const Run& run = m_runs[r];
    FlowField field;
    field.coord = run.coord;
    field.boundaries = &boundaries;
    field.gravity = gravity;
    field.dt = dt;
    field.reach = radius_of(GREATEST_SIZE);
    boundaries.walls_near(run.coord, field.walls, WallKind::all);
    FlowNodes& nodes = field.nodes;
    nodes.cell = cell;
    const std::int64_t first[3] = {run.coord.x, run.coord.y, run.coord.z};
    for (int axis = 0; axis < 3; ++axis)
      nodes.origin[axis] = static_cast<double>(first[axis] * BLOCK_SIDE);
    alignas(64) Scalar halo[HALO_VALUES];
    read_halo(grid, blocks, run.coord, m_isa, halo);
    const double full = m_density * cell * cell * cell;
    if constexpr (std::is_same_v<Scalar, float>)
      m_kernels->shape_flow_float(halo, full, m_settings.escape_density, nodes);
    else
      m_kernels->shape_flow_double(halo, full, m_settings.escape_density, nodes);
    reports[r] = update_run(run, field);
  });
  m_fastest = 0.0;
  m_strayed = false;
  for (const RunReport& report : reports) {
    m_fastest = std::max(m_fastest, report.fastest);
    m_strayed |= report.strayed;
  }
}

#define WRY_INSTANTIATE(AnyGrid)                                                                                       \
  template std::size_t SubParticles::update(const AnyGrid&, const Boundaries&, const Vec3&, double, double,            \
                                            const Threads&);
WRY_INSTANTIATE(Grid<float>)
WRY_INSTANTIATE(Grid<double>)
WRY_INSTANTIATE(SnapshotGrid)
#undef WRY_INSTANTIATE

} // namespace wry::mpm
