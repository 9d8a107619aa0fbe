#include "sim/mpm/grains/sub_particles.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "sim/base/rotation.h"
#include "sim/mpm/grains/blue_noise.h"
#include "sim/mpm/grains/dice.h"
#include "sim/mpm/matter/orientation.h"

namespace wry::mpm {

namespace {

constexpr int BLEND_UPDATES = 5;
/// Where the fringe of a pile is thinner than this share of capture_density, matter that lies still would hold grains
/// up to a cell and a half above it.
constexpr double FLOATING = 0.25;
constexpr double REST_SPEED = 0.03;   // [m/s] relative to what carries the grain
constexpr double LONGEST_TURN = 0.25; // dt |L| between updates

/// Four floats that are added together: velocity times activity, and activity.
typedef float Quad __attribute__((vector_size(16)));

constexpr int SIDE = HALO_SIDE;
constexpr int NODES = SIDE * SIDE * SIDE;

} // namespace

/// What grains of a block see in an update.
struct SubParticles::Field {
  alignas(64) Quad flow[NODES];
  alignas(64) float density[NODES]; ///< share of rho_0
  BlockCoord coord;
  Vec3 origin;                ///< of the block's first node, in cells
  float least_density = 0.0F; ///< of all nodes
  std::vector<NearWall> walls;
  const Boundaries* boundaries = nullptr;
  Vec3 gravity;
  double cell = 0.0, dt = 0.0;

  /// Weights of quadratic B-splines along an axis, and the first node's distance.
  struct Axis {
    float w[3], d[3]; ///< weight, and weight times node minus point [cells]
  };
  /// The first of three nodes along an axis, counted in the halo. Nothing but that count knows the block, so that a
  /// grain's answer is the same, bit for bit, whichever block it is sorted into.
  static int first_node(double along, double block_origin, Axis& axis) {
    const double base = std::floor(along - 0.5);
    const float f = static_cast<float>(along - base);
    const float w[3] = {0.5F * (1.5F - f) * (1.5F - f), 0.75F - (f - 1.0F) * (f - 1.0F),
                        0.5F * (f - 0.5F) * (f - 0.5F)};
    for (int i = 0; i < 3; ++i) {
      axis.w[i] = w[i];
      axis.d[i] = w[i] * (static_cast<float>(i) - f);
    }
    return std::clamp(static_cast<int>(base - block_origin) + 1, 0, SIDE - 3); // the halo begins a node earlier
  }
  int stencil(const Vec3& point, std::array<Axis, 3>& axes) const {
    int first = 0;
    for (int k = 0; k < 3; ++k)
      first = first * SIDE + first_node(point[k] / cell, origin[k], axes[static_cast<std::size_t>(k)]);
    return first;
  }
  /// Sum of weights times density, as a share of rho_0.
  double density_at(const Vec3& point) const {
    std::array<Axis, 3> a;
    const int first = stencil(point, a);
    return density_in(a, first);
  }
  double density_in(const std::array<Axis, 3>& a, int first) const {
    float sum = 0.0F;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const float* row = density + first + (i * SIDE + j) * SIDE;
        sum += a[0].w[i] * a[1].w[j] * (a[2].w[0] * row[0] + a[2].w[1] * row[1] + a[2].w[2] * row[2]);
      }
    }
    return sum;
  }
  /// Velocity and its gradient as APIC sees it, both by least squares over the active nodes (S7). False where the
  /// matter is thinner than `least`, or no node is active.
  bool motion_at(const Vec3& point, double least, Vec3& velocity, Mat3& gradient) const {
    std::array<Axis, 3> a;
    const int first = stencil(point, a);
    // Where every node is denser, so is their mean; a little more, for its rounding.
    if (least_density < 1.0001 * least && density_in(a, first) < least)
      return false;
    // Axis by axis, since weights are products.
    Quad sum = {}, along[3] = {};
    for (int i = 0; i < 3; ++i) {
      Quad plain_y = {}, slope_y = {}, slope_z = {};
      for (int j = 0; j < 3; ++j) {
        const Quad* row = flow + first + (i * SIDE + j) * SIDE;
        const Quad plain = a[2].w[0] * row[0] + a[2].w[1] * row[1] + a[2].w[2] * row[2];
        slope_z += a[1].w[j] * (a[2].d[0] * row[0] + a[2].d[1] * row[1] + a[2].d[2] * row[2]);
        plain_y += a[1].w[j] * plain;
        slope_y += a[1].d[j] * plain;
      }
      sum += a[0].w[i] * plain_y;
      along[0] += a[0].d[i] * plain_y;
      along[1] += a[0].w[i] * slope_y;
      along[2] += a[0].w[i] * slope_z;
    }
    if (!(sum[3] > 1e-6F))
      return false;
    const double inverse = 1.0 / static_cast<double>(sum[3]);
    velocity = Vec3(sum[0], sum[1], sum[2]) * inverse;
    const Vec3 centre = Vec3(along[0][3], along[1][3], along[2][3]) * inverse;
    for (int k = 0; k < 3; ++k)
      gradient.col(k) = Vec3(along[k][0], along[k][1], along[k][2]) * inverse - centre[k] * velocity;
    gradient *= 4.0 / cell; // the second moment of a full stencil is h^2 / 4
    if (sum[3] < 0.999F)
      gradient *= shrunk(a, first, inverse, centre);
    return true;
  }

private:
  /// (h^2/4) K^-1 of a stencil with inactive nodes, K their second moment about their mean; its inverse is damped where
  /// the nodes lie in a plane.
  Mat3 shrunk(const std::array<Axis, 3>& a, int first, double inverse, const Vec3& centre) const {
    float squared[3][3]; // weight times squared distance, per axis and node
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t at = 0; at < 3; ++at) {
        const float weight = a[axis].w[at], moment = a[axis].d[at];
        squared[axis][at] = weight > 1e-9F ? moment * moment / weight : 0.0F;
      }
    }
    float xx = 0.0F, yy = 0.0F, zz = 0.0F, yz = 0.0F, xz = 0.0F, xy = 0.0F;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const Quad* row = flow + first + (i * SIDE + j) * SIDE;
        float plain = 0.0F, slope = 0.0F, curve = 0.0F;
        for (int k = 0; k < 3; ++k) {
          const float active = row[k][3];
          plain += active * a[2].w[k];
          slope += active * a[2].d[k];
          curve += active * squared[2][k];
        }
        xx += squared[0][i] * a[1].w[j] * plain;
        yy += a[0].w[i] * squared[1][j] * plain;
        zz += a[0].w[i] * a[1].w[j] * curve;
        yz += a[0].w[i] * a[1].d[j] * slope;
        xz += a[0].d[i] * a[1].w[j] * slope;
        xy += a[0].d[i] * a[1].d[j] * plain;
      }
    }
    Mat3 K;
    K << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    K = K * inverse - centre * centre.transpose();
    const Mat3 damped = 4.0 * K + 0.05 * Mat3::Identity();
    Mat3 adjugate;
    adjugate.row(0) = damped.col(1).cross(damped.col(2));
    adjugate.row(1) = damped.col(2).cross(damped.col(0));
    adjugate.row(2) = damped.col(0).cross(damped.col(1));
    return adjugate / damped.col(0).dot(damped.col(1).cross(damped.col(2)));
  }
};

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

void SubParticles::meet_obstacles(std::size_t grain, const Field& field) {
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
bool SubParticles::carry(std::size_t grain, const Field& field) {
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

void SubParticles::fly(std::size_t grain, const Field& field) {
  m_velocity[grain] += field.dt * field.gravity;
  m_position[grain] += field.dt * m_velocity[grain];
  m_orientation[grain] =
      quaternion_product(quaternion_exponential(field.dt * m_spin[grain]), m_orientation[grain]).normalized();
}

/// What carries a resting grain; it flies again when that moves or is gone.
bool SubParticles::rest(std::size_t grain, const Field& field) {
  const std::optional<ObstacleContact> carrier =
      field.walls.empty()
          ? std::nullopt
          : field.boundaries->nearest_obstacle(field.walls, m_position[grain], m_settings.size.maxCoeff());
  m_velocity[grain] = carrier ? carrier->velocity : Vec3(Vec3::Zero());
  return carrier && carrier->velocity.norm() < 1e-9;
}

/// Returns whether a grain has strayed too far from the block.
bool SubParticles::update_run(const Run& run, const Field& field) {
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

template <class Scalar>
void SubParticles::follow(const Grid<Scalar>& grid, const Boundaries& boundaries, const Vec3& gravity, double cell,
                          double dt, double max_speed, double max_gradient, When when, const Threads& threads) {
  m_pending += dt;
  m_gone += dt * std::max(max_speed, m_fastest + m_pending * gravity.norm()) / cell;
  m_turned += dt * max_gradient;
  if (when == When::as_needed && m_gone < m_settings.travel && m_turned < LONGEST_TURN)
    return;
  if (m_strayed)
    sort(cell);
  BlockIndex blocks;
  blocks.reserve(grid.block_count());
  for (std::size_t b = 0; b < grid.block_count(); ++b)
    blocks.emplace(grid.coord(b), static_cast<std::int32_t>(b));
  const double whole = m_density * cell * cell * cell;
  std::vector<double> fastest(m_runs.size(), 0.0);
  std::vector<char> strayed(m_runs.size(), 0);
  threads.for_each(m_runs.size(), 1, [&](std::size_t r) {
    const Run& run = m_runs[r];
    Field field;
    field.coord = run.coord;
    field.origin =
        Vec3(static_cast<double>(run.coord.x), static_cast<double>(run.coord.y), static_cast<double>(run.coord.z)) *
        BLOCK_SIDE;
    field.boundaries = &boundaries;
    field.gravity = gravity;
    field.cell = cell;
    field.dt = m_pending;
    boundaries.walls_near(run.coord, field.walls, WallKind::all);
    const Scalar* near[27];
    for (int n = 0; n < 27; ++n) {
      const auto found = blocks.find({run.coord.x + n / 9 - 1, run.coord.y + n / 3 % 3 - 1, run.coord.z + n % 3 - 1});
      near[n] = found == blocks.end() ? nullptr : grid.values(static_cast<std::size_t>(found->second));
    }
    for (int node = 0; node < NODES; ++node) {
      const int at[3] = {node / (SIDE * SIDE) - 1, node / SIDE % SIDE - 1, node % SIDE - 1};
      int block = 0, place = 0;
      for (const int k : at) {
        block = block * 3 + (k + BLOCK_SIDE) / BLOCK_SIDE;
        place = place * BLOCK_SIDE + (k + BLOCK_SIDE) % BLOCK_SIDE;
      }
      const Scalar* value = near[block] == nullptr ? nullptr : near[block] + place * NODE_VALUES;
      const double share = value == nullptr ? 0.0 : static_cast<double>(value[3]) / whole;
      field.density[node] = static_cast<float>(share);
      const bool active = share >= m_settings.escape_density;
      field.flow[node] =
          active ? Quad{static_cast<float>(value[0]), static_cast<float>(value[1]), static_cast<float>(value[2]), 1.0F}
                 : Quad{};
    }
    field.least_density = *std::min_element(field.density, field.density + NODES);
    strayed[r] = update_run(run, field) ? 1 : 0;
    for (std::size_t i = run.begin; i < run.end; ++i) {
      if (m_state[m_order[i]] == Phase::flying)
        fastest[r] = std::max(fastest[r], m_velocity[m_order[i]].norm());
    }
  });
  m_fastest = fastest.empty() ? 0.0 : *std::max_element(fastest.begin(), fastest.end());
  m_strayed = std::find(strayed.begin(), strayed.end(), 1) != strayed.end();
  m_pending = m_gone = m_turned = 0.0;
  ++m_updates;
}

template void SubParticles::follow(const Grid<float>&, const Boundaries&, const Vec3&, double, double, double, double,
                                   When, const Threads&);
template void SubParticles::follow(const Grid<double>&, const Boundaries&, const Vec3&, double, double, double, double,
                                   When, const Threads&);

SubParticleCounts SubParticles::counts() const {
  SubParticleCounts counts;
  for (const Phase phase : m_state) {
    counts.carried += phase == Phase::carried ? 1 : 0;
    counts.flying += phase == Phase::flying ? 1 : 0;
    counts.resting += phase == Phase::resting ? 1 : 0;
  }
  return counts;
}

SceneBody SubParticles::scene_body() const {
  SceneBody body;
  body.name = m_settings.name;
  body.kind = BodyKind::particles;
  body.grain = {m_settings.shape, m_settings.size};
  body.look = m_settings.look;
  return body;
}

FrameBody SubParticles::snapshot() const {
  const std::size_t n = count();
  const auto make = [n](const char* name, int components, ChannelStorage storage) {
    return wry::Channel{name, ChannelOn::particle, components, storage,
                        std::vector<double>(n * static_cast<std::size_t>(components))};
  };
  wry::Channel position = make("position", 3, ChannelStorage::float64);
  wry::Channel orientation = make("orientation", 4, ChannelStorage::float32);
  wry::Channel size = make("size", 3, ChannelStorage::float32);
  wry::Channel velocity = make("velocity", 3, ChannelStorage::float32);
  wry::Channel phase = make("phase", 1, ChannelStorage::float32);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      position.values[3 * i + k] = m_position[i][axis];
      velocity.values[3 * i + k] = m_velocity[i][axis];
      size.values[3 * i + k] = m_settings.size[axis] * static_cast<double>(m_size[i]);
    }
    for (std::size_t k = 0; k < 4; ++k)
      orientation.values[4 * i + k] = m_orientation[i][static_cast<Eigen::Index>(k)];
    phase.values[i] = static_cast<double>(m_state[i]);
  }
  FrameBody body;
  body.name = m_settings.name;
  body.channels = {std::move(position), std::move(orientation), std::move(size), std::move(velocity), std::move(phase)};
  return body;
}

void SubParticles::archive(const std::string& prefix, StateArchive& to) const {
  NamedArray state{prefix + "/grains", {count(), 15}, std::vector<double>(count() * 15)};
  for (std::size_t i = 0; i < count(); ++i) {
    double* row = state.values.data() + 15 * i;
    for (Eigen::Index k = 0; k < 3; ++k) {
      row[k] = m_position[i][k];
      row[3 + k] = m_velocity[i][k];
      row[6 + k] = m_spin[i][k];
    }
    for (Eigen::Index k = 0; k < 4; ++k)
      row[9 + k] = m_orientation[i][k];
    row[13] = static_cast<double>(m_state[i]);
    row[14] = static_cast<double>(m_blend[i]);
  }
  to.push_back(std::move(state));
  to.push_back({prefix + "/pending", {5}, {m_fastest, m_pending, m_gone, m_turned, static_cast<double>(m_updates)}});
}

Status SubParticles::restore(const std::string& prefix, const StateArchive& from) {
  const auto find = [&](const std::string& name, std::size_t size) -> const NamedArray* {
    for (const NamedArray& array : from) {
      if (array.name == name && array.values.size() == size)
        return &array;
    }
    return nullptr;
  };
  const NamedArray* state = find(prefix + "/grains", count() * 15);
  const NamedArray* pending = find(prefix + "/pending", 5);
  if (state == nullptr || pending == nullptr)
    return make_error(ErrorCode::io, "the checkpoint has no {}/{} that fits this shot", prefix,
                      state == nullptr ? "grains" : "pending");
  for (std::size_t i = 0; i < count(); ++i) {
    const double* row = state->values.data() + 15 * i;
    m_position[i] = Vec3(row[0], row[1], row[2]);
    m_velocity[i] = Vec3(row[3], row[4], row[5]);
    m_spin[i] = Vec3(row[6], row[7], row[8]);
    m_orientation[i] = Vec4(row[9], row[10], row[11], row[12]);
    m_state[i] = static_cast<Phase>(row[13]);
    m_blend[i] = static_cast<std::uint8_t>(row[14]);
  }
  m_fastest = pending->values[0];
  m_pending = pending->values[1];
  m_gone = pending->values[2];
  m_turned = pending->values[3];
  m_updates = static_cast<std::size_t>(pending->values[4]);
  m_strayed = true; // a grain's answer does not depend on the block that it is sorted into
  return {};
}

} // namespace wry::mpm
