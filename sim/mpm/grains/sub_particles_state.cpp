#include "sim/mpm/grains/sub_particles.h"

namespace wry::mpm {

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
  if (m_settings.mesh) {
    body.rest_positions = m_settings.mesh->vertices;
    body.triangles = m_settings.mesh->triangles;
  }
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
      position.values[3 * i + k] = m_grains[i].position[axis];
      velocity.values[3 * i + k] = m_grains[i].velocity[axis];
      size.values[3 * i + k] = m_settings.size[axis] * static_cast<double>(m_size[i]);
    }
    for (std::size_t k = 0; k < 4; ++k)
      orientation.values[4 * i + k] = m_grains[i].orientation[static_cast<Eigen::Index>(k)];
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
      row[k] = m_grains[i].position[k];
      row[3 + k] = m_grains[i].velocity[k];
      row[6 + k] = m_grains[i].spin[k];
    }
    for (Eigen::Index k = 0; k < 4; ++k)
      row[9 + k] = m_grains[i].orientation[k];
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
    m_grains[i].position = Vec3(row[0], row[1], row[2]);
    m_grains[i].velocity = Vec3(row[3], row[4], row[5]);
    m_grains[i].spin = Vec3(row[6], row[7], row[8]);
    m_grains[i].orientation = Vec4(row[9], row[10], row[11], row[12]);
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
