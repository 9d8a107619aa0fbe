#include "sim/mpm/grains/grain_followers.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "sim/base/rotation.h"

namespace wry::mpm {

GrainFollowers::GrainFollowers(const MpmPlan& plan, const Boundaries& boundaries, Isa isa)
    : m_gravity(plan.gravity)
    , m_cell(plan.settings.cell)
    , m_keeps(plan.settings.keep_fields ? Fields::kept : Fields::dropped) {
  for (const MpmBody& body : plan.bodies) {
    if (!body.sub_particles)
      continue;
    SubParticleSettings settings = *body.sub_particles;
    if (m_keeps == Fields::kept)
      settings.clock = GrainClock::matter;
    const Quaternions one = quaternion_of(body.frame).transpose();
    const SubParticleStart start{*body.positions, body.particle_volume, body.frames ? *body.frames : one,
                                 body.initial_velocity, body.material.density};
    m_grains.emplace_back(std::move(settings), start, isa);
    m_grains.back().leave_obstacles(boundaries, m_cell);
  }
}

template <class Scalar>
std::size_t GrainFollowers::follow(const Grid<Scalar>& grid, const Boundaries& boundaries, double time,
                                   const SubParticles::StepSeen& step, const Threads& threads) {
  std::vector<double> spans;
  std::size_t updated = 0;
  for (SubParticles& grains : m_grains) {
    spans.push_back(grains.due(step, m_gravity, m_cell));
    if (spans.back() > 0.0)
      updated += grains.update(grid, boundaries, m_gravity, m_cell, spans.back(), threads);
  }
  const bool any = std::any_of(spans.begin(), spans.end(), [](double span) { return span > 0.0; });
  if (any && m_keeps == Fields::kept)
    m_fields.push_back({time, step.dt, std::move(spans), snapshot_of(grid)});
  return updated;
}
template std::size_t GrainFollowers::follow(const Grid<float>&, const Boundaries&, double,
                                            const SubParticles::StepSeen&, const Threads&);
template std::size_t GrainFollowers::follow(const Grid<double>&, const Boundaries&, double,
                                            const SubParticles::StepSeen&, const Threads&);

std::vector<GrainUpdate> GrainFollowers::take_fields() {
  return std::exchange(m_fields, {});
}

Status GrainFollowers::replay(const std::vector<GrainUpdate>& updates, Boundaries& boundaries, const Threads& threads) {
  for (const GrainUpdate& update : updates) {
    if (update.spans.size() != m_grains.size())
      return make_error(ErrorCode::bad_input, "fields were kept for {} bodies with grains, the shot has {}",
                        update.spans.size(), m_grains.size());
    boundaries.begin_step(update.time, update.dt);
    const SnapshotGrid grid(update.grid);
    for (std::size_t i = 0; i < m_grains.size(); ++i) {
      if (update.spans[i] > 0.0)
        m_grains[i].update(grid, boundaries, m_gravity, m_cell, update.spans[i], threads);
    }
  }
  return {};
}

void GrainFollowers::add_to(SceneStatic& scene) const {
  for (const SubParticles& grains : m_grains)
    scene.bodies.push_back(grains.scene_body());
}

void GrainFollowers::add_to(Frame& frame) const {
  for (const SubParticles& grains : m_grains)
    frame.bodies.push_back(grains.snapshot());
}

void GrainFollowers::archive(StateArchive& to) const {
  for (std::size_t i = 0; i < m_grains.size(); ++i)
    m_grains[i].archive(fmt::format("mpm/grains{}", i), to);
  archive_updates(m_fields, "mpm/fields", to);
}

Status GrainFollowers::restore(const StateArchive& from) {
  for (std::size_t i = 0; i < m_grains.size(); ++i) {
    if (Status status = m_grains[i].restore(fmt::format("mpm/grains{}", i), from); !status)
      return status;
  }
  Result<std::vector<GrainUpdate>> fields = restore_updates(from, "mpm/fields");
  if (!fields)
    return fields.error();
  m_fields = std::move(*fields);
  return {};
}

std::size_t GrainFollowers::memory_bytes() const {
  std::size_t bytes = 0;
  for (const SubParticles& grains : m_grains)
    bytes += grains.count() * BYTES_PER_GRAIN;
  for (const GrainUpdate& update : m_fields)
    bytes += update.grid.bytes();
  return bytes;
}

} // namespace wry::mpm
