#include "sim/mpm/mpm_simulation.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "sim/base/rotation.h"

#include "sim/mpm/boundaries.h"
#include "sim/mpm/grains/grain_followers.h"
#include "sim/mpm/kernels/transfer_table.h"
#include "sim/mpm/mpm_state.h"
#include "sim/mpm/particle_blocks.h"
#include "sim/mpm/semi_implicit.h"
#include "sim/mpm/totals.h"
#include "sim/mpm/transfer_run.h"

namespace wry::mpm {

namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Where the blocks around an occupied one are in `values`.
template <class Scalar, class Values>
std::array<Values*, NEIGHBOURS> blocks_around(const Grid<Scalar>& grid, std::size_t block, Values* values) {
  std::array<Values*, NEIGHBOURS> around;
  const std::array<std::int32_t, NEIGHBOURS>& neighbours = grid.neighbours(block);
  for (std::size_t n = 0; n < NEIGHBOURS; ++n)
    around[n] = values + static_cast<std::size_t>(neighbours[n]) * BLOCK_VALUES;
  return around;
}

/// What a block's gather found.
struct BlockReport {
  GatherReport sums;
  double kinetic_energy = 0.0;
  int failed_body = -1;
  std::size_t failed_place = 0;
  BlockRun failed_run;
};

template <class Scalar> class Simulation final : public MpmSimulation {
public:
  Simulation(MpmPlan plan, int threads, Isa isa, Boundaries boundaries)
      : m_plan(std::move(plan))
      , m_threads(threads)
      , m_isa(isa)
      , m_transfers(transfer_kernels<Scalar>(isa))
      , m_boundaries(std::move(boundaries)) {}

  Status initialise();

  Result<StepStats> step(double end) override;
  double time() const override { return m_state.time; }
  std::size_t particle_count() const override;
  StepBound bound() const override;
  Totals totals() const override { return sum_totals(m_plan, m_bodies, m_state); }
  SceneStatic scene_static() const override;
  Frame snapshot(int number) const override;
  std::vector<GrainUpdate> take_fields() override { return m_grains->take_fields(); }
  Status replay(const std::vector<GrainUpdate>& updates) override {
    return m_grains->replay(updates, m_boundaries, m_threads);
  }
  StateArchive archive() const override;
  Status restore(const StateArchive& archive) override;
  std::size_t memory_bytes() const override;

private:
  static constexpr std::size_t WIDTH = TILE_WIDTH<Scalar>;

  Status add_particles(std::size_t body);
  Result<bool> emit();
  Status sort();
  void make_blocks();
  TransferRun<Scalar> run_of(std::size_t body, const BlockRun& run, double dt) {
    return transfer_run(m_bodies[body], m_state.sets[body].particles, run, m_plan.settings.cell, dt);
  }
  void scatter(double force_dt, Scalar* values);
  void update_grid(double dt);
  SolveReport solve_semi_implicit(double dt);
  void freeze_tangents();
  void apply_stiffness(const Scalar* velocities, Scalar* forces);
  void constrain_grid();
  Status gather(double dt, StepStats& stats);
  BlockReport gather_block(std::size_t block, double dt);
  bool keep_out_of_walls(std::size_t body, const BlockRun& run, const std::vector<NearWall>& walls);
  Error lost_particle(const BlockReport& report, double dt) const;
  double stiffest_speed() const;

  MpmPlan m_plan;
  Threads m_threads;
  Isa m_isa;
  const TransferKernels<Scalar>& m_transfers;
  Boundaries m_boundaries;
  std::vector<BodyState<Scalar>> m_bodies;
  MpmState<Scalar> m_state;
  Grid<Scalar> m_grid;
  SemiImplicitSolver<Scalar> m_implicit;       ///< of semi-implicit steps
  std::vector<AlignedVector<Scalar>> m_frozen; ///< per body: what its tangent kernel has frozen
  std::optional<GrainFollowers> m_grains;      ///< once there are particles
  ParticleBlocks m_blocks;
};

template <class Scalar> Status Simulation<Scalar>::initialise() {
  m_state.emitted.assign(m_plan.sources.size(), 0);
  for (std::size_t b = 0; b < m_plan.bodies.size(); ++b) {
    const MpmBody& body = m_plan.bodies[b];
    if (!body.positions || body.positions->rows() == 0)
      return make_error(ErrorCode::bad_input, "body {}: there is no particle in it", body.name);
    Result<CompiledMaterial> compiled = compile_material(body.material);
    if (!compiled)
      return compiled.error();
    BodyState<Scalar> state;
    state.compiled = std::move(*compiled);
    state.constants = constants_in<Scalar>(state.compiled.constants);
    state.kernels = find_material_kernels<Scalar>(body.material, state.compiled, m_isa);
    state.mass = static_cast<Scalar>(body.material.density * body.particle_volume);
    state.volume = static_cast<Scalar>(body.particle_volume);
    m_state.sets.push_back({ParticleSet<Scalar>(state.compiled.channels), {}});
    m_state.stiffness_factor.push_back(1.0);
    m_bodies.push_back(std::move(state));
    if (Status status = add_particles(b); !status)
      return status;
  }
  m_grains.emplace(m_plan, m_boundaries, m_isa);
  make_blocks();
  return {};
}

/// Adds the particles of the plan's body once more, as they are at the start.
template <class Scalar> Status Simulation<Scalar>::add_particles(std::size_t body) {
  const MpmBody& plan = m_plan.bodies[body];
  SortedSet<Scalar>& set = m_state.sets[body];
  std::vector<NewParticle> added;
  added.reserve(static_cast<std::size_t>(plan.positions->rows()));
  for (Eigen::Index i = 0; i < plan.positions->rows(); ++i) {
    const Result<NewParticle> particle = place_in_grid(plan.positions->row(i), m_plan.settings.cell);
    if (!particle)
      return make_error(particle.error().code, "body {}: particle {}: {}", plan.name, i, particle.error().message);
    added.push_back(*particle);
    double speed = plan.initial_velocity.norm();
    if (plan.velocity_field)
      speed += plan.velocity_field(plan.positions->row(i)).norm();
    m_state.max_speed = std::max(m_state.max_speed, speed);
  }
  const std::int64_t first = static_cast<std::int64_t>(set.count());
  if (Status status = sort_particles<Scalar>(set, added, first, m_threads); !status)
    return status;
  start_particles(plan, first, set);
  return {};
}

template <class Scalar> Status Simulation<Scalar>::sort() {
  for (SortedSet<Scalar>& set : m_state.sets) {
    if (Status status = sort_particles<Scalar>(set, {}, 0, m_threads); !status)
      return make_error(status.error().code, "t = {:.6g} s: {}", m_state.time, status.error().message);
  }
  make_blocks();
  m_state.strayed = false;
  return {};
}

template <class Scalar> void Simulation<Scalar>::make_blocks() {
  const std::vector<BlockCoord> occupied = occupied_blocks<Scalar>(m_state.sets);
  m_grid.build(occupied);
  m_blocks.build(m_state.sets, occupied);
}

template <class Scalar> std::size_t Simulation<Scalar>::particle_count() const {
  std::size_t sum = 0;
  for (const SortedSet<Scalar>& set : m_state.sets)
    sum += set.count();
  return sum;
}

template <class Scalar> double Simulation<Scalar>::stiffest_speed() const {
  double speed = 0.0;
  for (std::size_t b = 0; b < m_bodies.size(); ++b)
    speed = std::max(speed, m_bodies[b].compiled.sound_speed * std::sqrt(m_state.stiffness_factor[b]));
  return speed;
}

template <class Scalar> StepBound Simulation<Scalar>::bound() const {
  StepFacts facts;
  facts.cell = m_plan.settings.cell;
  facts.courant = m_plan.settings.courant;
  facts.max_deformation = m_plan.settings.max_deformation;
  if (m_plan.settings.semi_implicit)
    facts.wave_courant = m_plan.settings.semi_implicit->courant;
  facts.sound_speed = stiffest_speed();
  facts.speed = m_state.max_speed;
  facts.gravity = m_plan.gravity.norm();
  facts.gradient = m_state.max_gradient;
  const StepBound without_obstacles = stable_step(facts);
  facts.speed = std::max(facts.speed, m_boundaries.max_speed(m_state.time, std::min(without_obstacles.dt, 1.0)));
  return stable_step(facts);
}

/// Fills all blocks of `values` with momentum, after so long of the internal forces, and mass.
template <class Scalar> void Simulation<Scalar>::scatter(double force_dt, Scalar* values) {
  m_threads.for_chunks(m_grid.block_count(), 64, [&](std::size_t begin, std::size_t end) {
    std::fill(values + begin * BLOCK_VALUES, values + end * BLOCK_VALUES, Scalar(0));
  });
  const ScatterKernel<Scalar> kernel = m_transfers.scatter[static_cast<int>(m_plan.settings.transfer)];
  for (const std::vector<std::int32_t>& colour : m_blocks.colours()) {
    m_threads.for_each(colour.size(), 1, [&](std::size_t i) {
      const std::size_t block = static_cast<std::size_t>(colour[i]);
      alignas(64) Scalar halo[HALO_VALUES] = {};
      for (const auto& [body, run] : m_blocks.runs(block))
        kernel(run_of(body, m_state.sets[body].runs[run], force_dt), halo);
      m_transfers.add_halo(halo, blocks_around(m_grid, block, values).data());
    });
  }
}

template <class Scalar> void Simulation<Scalar>::update_grid(double dt) {
  Scalar gain[3];
  for (int axis = 0; axis < 3; ++axis)
    gain[axis] = static_cast<Scalar>(dt * m_plan.gravity[axis]);
  m_threads.for_each(m_grid.block_count(), 16, [&](std::size_t block) {
    Scalar* values = m_grid.values(block);
    bool any = false;
    for (int node = 0; node < BLOCK_VALUES; node += NODE_VALUES) {
      const Scalar mass = values[node + 3];
      if (!(mass > 0))
        continue;
      any = true;
      const Scalar inverse = Scalar(1) / mass;
      for (int axis = 0; axis < 3; ++axis)
        values[node + axis] = values[node + axis] * inverse + gain[axis];
    }
    if (any)
      m_boundaries.constrain_nodes(m_grid.coord(block), values,
                                   m_plan.settings.semi_implicit ? &m_implicit.constraints(block) : nullptr);
  });
}

template <class Scalar> void Simulation<Scalar>::freeze_tangents() {
  m_frozen.resize(m_bodies.size());
  for (std::size_t body = 0; body < m_bodies.size(); ++body) {
    const TangentKernel<Scalar>& tangent = m_bodies[body].kernels.tangent;
    const std::size_t per_tile = static_cast<std::size_t>(tangent.components) * WIDTH;
    const std::vector<BlockRun>& runs = m_state.sets[body].runs;
    m_frozen[body].resize(m_state.sets[body].particles.tiles() * per_tile);
    m_threads.for_each(runs.size(), 1, [&](std::size_t i) {
      ConstitutiveTiles<Scalar> tiles = run_of(body, runs[i], 0.0).tiles;
      tiles.count = static_cast<int>((static_cast<std::size_t>(runs[i].count) + WIDTH - 1) / WIDTH);
      tangent.freeze(m_bodies[body].constants, tiles,
                     m_frozen[body].data() + static_cast<std::size_t>(runs[i].first_tile) * per_tile);
    });
  }
}

/// forces <- K velocities, on all blocks.
template <class Scalar> void Simulation<Scalar>::apply_stiffness(const Scalar* velocities, Scalar* forces) {
  m_threads.for_chunks(m_grid.block_count(), 64, [&](std::size_t begin, std::size_t end) {
    std::fill(forces + begin * BLOCK_VALUES, forces + end * BLOCK_VALUES, Scalar(0));
  });
  const StiffnessKernel<Scalar> kernel =
      stiffness_kernels<Scalar>(m_isa).apply[static_cast<int>(m_plan.settings.transfer)];
  for (const std::vector<std::int32_t>& colour : m_blocks.colours()) {
    m_threads.for_each(colour.size(), 1, [&](std::size_t i) {
      const std::size_t block = static_cast<std::size_t>(colour[i]);
      alignas(64) Scalar from[HALO_VALUES];
      alignas(64) Scalar to[HALO_VALUES] = {};
      m_transfers.read_halo(blocks_around(m_grid, block, velocities).data(), from);
      std::fill(from + HALO_VALUES - NODE_VALUES, from + HALO_VALUES, Scalar(0));
      for (const auto& [body, index] : m_blocks.runs(block)) {
        const BlockRun& run = m_state.sets[body].runs[index];
        TransferRun<Scalar> transfer = run_of(body, run, 0.0);
        transfer.tangent = &m_bodies[body].kernels.tangent;
        transfer.frozen = m_frozen[body].data() + static_cast<std::size_t>(run.first_tile) * WIDTH *
                                                      static_cast<std::size_t>(transfer.tangent->components);
        kernel(transfer, from, to);
      }
      m_transfers.add_halo(to, blocks_around(m_grid, block, forces).data());
    });
  }
}

template <class Scalar> void Simulation<Scalar>::constrain_grid() {
  m_threads.for_each(m_grid.block_count(), 16, [&](std::size_t block) {
    m_boundaries.constrain_nodes(m_grid.coord(block), m_grid.values(block));
  });
}

/// From the grid of an explicit step after contact to that of the semi-implicit one.
template <class Scalar> SolveReport Simulation<Scalar>::solve_semi_implicit(double dt) {
  scatter(0.0, m_implicit.start());
  freeze_tangents();
  const auto stiffness = [this](const Scalar* from, Scalar* to) { apply_stiffness(from, to); };
  const SolveReport report =
      m_implicit.solve(m_grid, dt, m_plan.gravity, *m_plan.settings.semi_implicit, stiffness, m_threads);
  // Nodes that the solve let move into obstacles.
  constrain_grid();
  return report;
}

/// Returns whether a particle was put so far that it must be sorted before the next scatter: one that begins deep
/// inside a wall may leave the halo at once.
template <class Scalar>
bool Simulation<Scalar>::keep_out_of_walls(std::size_t body, const BlockRun& run, const std::vector<NearWall>& walls) {
  ParticleSet<Scalar>& particles = m_state.sets[body].particles;
  const double cell = m_plan.settings.cell;
  bool strayed = false;
  const std::size_t first = static_cast<std::size_t>(run.first_tile) * WIDTH;
  for (std::size_t i = 0; i < static_cast<std::size_t>(run.count); ++i) {
    Vec3 position = world_position(particles, run, first + i, cell);
    Vec3 velocity;
    for (int axis = 0; axis < 3; ++axis)
      velocity[axis] = particles.at(Channel::velocity, first + i, axis);
    if (!position.allFinite() || !m_boundaries.push_out(walls, position, velocity))
      continue;
    const std::int64_t coord[3] = {run.coord.x, run.coord.y, run.coord.z};
    for (int axis = 0; axis < 3; ++axis) {
      const double local = position[axis] / cell - static_cast<double>(coord[axis] * BLOCK_SIDE);
      strayed = strayed || local < LEAST_POSITION || local >= POSITION_END;
      particles.at(Channel::position, first + i, axis) = static_cast<Scalar>(local);
      particles.at(Channel::velocity, first + i, axis) = static_cast<Scalar>(velocity[axis]);
    }
  }
  return strayed;
}

template <class Scalar> BlockReport Simulation<Scalar>::gather_block(std::size_t block, double dt) {
  const GatherKernel<Scalar> kernel = m_transfers.gather[static_cast<int>(m_plan.settings.transfer)];
  alignas(64) Scalar halo[HALO_VALUES];
  const Grid<Scalar>& grid = m_grid;
  m_transfers.read_halo(blocks_around(grid, block, grid.values(0)).data(), halo);
  std::fill(halo + HALO_VALUES - NODE_VALUES, halo + HALO_VALUES, Scalar(0));
  BlockReport report;
  std::vector<NearWall> walls;
  m_boundaries.walls_near(
      m_state.sets[m_blocks.runs(block).front().first].runs[m_blocks.runs(block).front().second].coord, walls);
  for (const auto& [body, index] : m_blocks.runs(block)) {
    const BlockRun& run = m_state.sets[body].runs[index];
    const GatherReport one = kernel(run_of(body, run, dt), halo);
    if (!walls.empty())
      report.sums.strayed |= keep_out_of_walls(body, run, walls);
    report.sums.max_speed_squared = std::max(report.sums.max_speed_squared, one.max_speed_squared);
    report.sums.max_gradient_squared = std::max(report.sums.max_gradient_squared, one.max_gradient_squared);
    report.sums.strayed = report.sums.strayed || one.strayed;
    report.kinetic_energy += 0.5 * static_cast<double>(m_bodies[body].mass) * one.sum_speed_squared;
    report.sums.material.stiffness_factor =
        std::max(report.sums.material.stiffness_factor, one.material.stiffness_factor);
    if (report.failed_body < 0 && one.material.failed_lane >= 0) {
      report.failed_body = static_cast<int>(body);
      const int lane = std::min(one.material.failed_lane, run.count - 1);
      report.failed_place = static_cast<std::size_t>(run.first_tile) * WIDTH + static_cast<std::size_t>(lane);
      report.failed_run = run;
    }
  }
  return report;
}

template <class Scalar> Status Simulation<Scalar>::gather(double dt, StepStats& stats) {
  std::vector<BlockReport> reports(m_grid.occupied_count());
  m_threads.for_each(reports.size(), 1, [&](std::size_t block) { reports[block] = gather_block(block, dt); });
  BlockReport total;
  std::vector<double> factor(m_bodies.size(), 1.0);
  for (std::size_t block = 0; block < reports.size(); ++block) {
    const BlockReport& report = reports[block];
    if (report.failed_body >= 0)
      return lost_particle(report, dt);
    total.sums.max_speed_squared = std::max(total.sums.max_speed_squared, report.sums.max_speed_squared);
    total.sums.max_gradient_squared = std::max(total.sums.max_gradient_squared, report.sums.max_gradient_squared);
    total.sums.strayed = total.sums.strayed || report.sums.strayed;
    total.kinetic_energy += report.kinetic_energy;
    for (const auto& [body, run] : m_blocks.runs(block))
      factor[body] = std::max(factor[body], report.sums.material.stiffness_factor);
  }
  m_state.stiffness_factor = factor;
  m_state.max_speed = std::sqrt(total.sums.max_speed_squared);
  m_state.max_gradient = std::sqrt(total.sums.max_gradient_squared);
  m_state.strayed = total.sums.strayed;
  stats.kinetic_energy = total.kinetic_energy;
  stats.max_speed = m_state.max_speed;
  return {};
}

template <class Scalar> Error Simulation<Scalar>::lost_particle(const BlockReport& report, double dt) const {
  const std::size_t body = static_cast<std::size_t>(report.failed_body);
  const ParticleSet<Scalar>& particles = m_state.sets[body].particles;
  const Vec3 at = world_position(particles, report.failed_run, report.failed_place, m_plan.settings.cell);
  double speed = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    speed += std::pow(static_cast<double>(particles.at(Channel::velocity, report.failed_place, axis)), 2);
  return make_error(
      ErrorCode::solver,
      "body {}: t = {:.6g} s, dt = {:.3g} s: the deformation of particle {} at ({:.4g}, {:.4g}, {:.4g}) m is lost (it "
      "turned inside out, or is no number); its speed is {:.4g} m/s, the wave speed {:.4g} m/s, the cell {:.4g} m. Try "
      "a "
      "smaller mpm.courant or mpm.max_deformation, or slower obstacles; the last good frame is kept",
      m_plan.bodies[body].name, m_state.time, dt, identity_of(particles.at(Channel::identity, report.failed_place, 0)),
      at.x(), at.y(), at.z(), std::sqrt(speed), stiffest_speed(), m_plan.settings.cell);
}

/// Adds what sources owe up to now.
template <class Scalar> Result<bool> Simulation<Scalar>::emit() {
  bool any = false;
  for (std::size_t s = 0; s < m_plan.sources.size(); ++s) {
    const Source& source = m_plan.sources[s];
    const double due = source.from + source.every * static_cast<double>(m_state.emitted[s]);
    if (due > source.until * (1.0 + 1e-12) || m_state.time < due * (1.0 - 1e-12))
      continue;
    ++m_state.emitted[s];
    any = true;
    if (Status status = add_particles(static_cast<std::size_t>(source.body)); !status)
      return status.error();
  }
  return any;
}

template <class Scalar> Result<StepStats> Simulation<Scalar>::step(double end) {
  const Clock::time_point start = Clock::now();
  if (!(end > m_state.time))
    return make_error(ErrorCode::usage, "cannot step from {} s to {} s", m_state.time, end);
  StepStats stats;
  const Result<bool> emitted = emit();
  if (!emitted)
    return emitted.error();
  if (m_state.strayed || *emitted) {
    if (Status status = sort(); !status)
      return status.error();
    stats.sorted = true;
  }
  stats.sort_ms = ms_since(start);
  const ChosenStep chosen = choose_step(bound(), m_plan.settings.time_step, m_state.time, end);
  m_boundaries.begin_step(m_state.time, chosen.dt);
  const Clock::time_point before_scatter = Clock::now();
  scatter(chosen.dt, m_grid.values(0));
  const Clock::time_point before_grid = Clock::now();
  if (m_plan.settings.semi_implicit)
    m_implicit.fit(m_grid.block_count());
  update_grid(chosen.dt);
  if (m_plan.settings.semi_implicit)
    stats.linear_iterations = solve_semi_implicit(chosen.dt).iterations;
  const Clock::time_point before_gather = Clock::now();
  if (Status status = gather(chosen.dt, stats); !status)
    return status.error();
  const Clock::time_point before_grains = Clock::now();
  stats.grain_updates = m_grains->follow(m_grid, m_boundaries, m_state.time,
                                         {chosen.dt, m_state.max_speed, m_state.max_gradient, chosen.lands}, m_threads);
  stats.grains_ms = ms_since(before_grains);
  m_state.time = chosen.lands ? end : m_state.time + chosen.dt;
  stats.time = m_state.time;
  stats.dt = chosen.dt;
  stats.limit = chosen.limit;
  stats.given_over_stable = chosen.given_over_stable;
  stats.particles = particle_count();
  stats.blocks = m_grid.occupied_count();
  stats.scatter_ms = std::chrono::duration<double, std::milli>(before_grid - before_scatter).count();
  stats.grid_ms = std::chrono::duration<double, std::milli>(before_gather - before_grid).count();
  stats.gather_ms = std::chrono::duration<double, std::milli>(before_grains - before_gather).count();
  stats.total_ms = ms_since(start);
  return stats;
}

template <class Scalar> SceneStatic Simulation<Scalar>::scene_static() const {
  SceneStatic scene;
  for (const MpmBody& body : m_plan.bodies) {
    SceneBody described;
    described.name = body.name;
    described.look = body.look;
    // Grains are drawn in its place: a surface without triangles is nothing to be seen.
    described.kind = body.sub_particles ? BodyKind::surface : BodyKind::particles;
    // As large as the matter that a particle stands for.
    described.grain.shape = GrainShape::sphere;
    described.grain.size = Vec3::Constant(std::cbrt(body.particle_volume * 6.0 / std::numbers::pi));
    scene.bodies.push_back(std::move(described));
  }
  m_grains->add_to(scene);
  return scene;
}

template <class Scalar> Frame Simulation<Scalar>::snapshot(int number) const {
  Frame frame;
  frame.number = number;
  frame.time = m_state.time;
  for (std::size_t b = 0; b < m_plan.bodies.size(); ++b)
    frame.bodies.push_back(snapshot_body(m_plan.bodies[b], m_state.sets[b], m_plan.settings.cell));
  m_grains->add_to(frame);
  return frame;
}

template <class Scalar> StateArchive Simulation<Scalar>::archive() const {
  StateArchive archive = archive_state(m_state);
  m_grains->archive(archive);
  return archive;
}

template <class Scalar> Status Simulation<Scalar>::restore(const StateArchive& archive) {
  if (Status status = restore_state(archive, m_state); !status)
    return status;
  if (Status status = m_grains->restore(archive); !status)
    return status;
  make_blocks();
  return {};
}

template <class Scalar> std::size_t Simulation<Scalar>::memory_bytes() const {
  std::size_t bytes = m_grid.memory_bytes() + m_implicit.memory_bytes() + m_grains->memory_bytes();
  for (const AlignedVector<Scalar>& frozen : m_frozen)
    bytes += frozen.capacity() * sizeof(Scalar);
  for (const SortedSet<Scalar>& set : m_state.sets) {
    // While particles are sorted there are two copies, and where each goes.
    bytes += set.particles.tiles() * WIDTH * (2 * set.particles.bytes_per_particle() + 100);
  }
  return bytes;
}

template <class Scalar>
Result<std::unique_ptr<MpmSimulation>> make_simulation(MpmPlan plan, int threads, Isa isa, Boundaries boundaries) {
  std::unique_ptr<Simulation<Scalar>> simulation =
      std::make_unique<Simulation<Scalar>>(std::move(plan), threads, isa, std::move(boundaries));
  if (Status status = simulation->initialise(); !status)
    return status.error();
  return std::unique_ptr<MpmSimulation>(std::move(simulation));
}

} // namespace

Result<std::unique_ptr<MpmSimulation>> MpmSimulation::create(MpmPlan plan, int threads, Isa isa) {
  Result<Boundaries> boundaries = Boundaries::create(plan);
  if (!boundaries)
    return boundaries.error();
  if (plan.settings.precision == Precision::f32)
    return make_simulation<float>(std::move(plan), threads, isa, std::move(*boundaries));
  return make_simulation<double>(std::move(plan), threads, isa, std::move(*boundaries));
}

} // namespace wry::mpm
