#include "sim/mpm/mpm_state.h"

#include <algorithm>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "sim/base/rotation.h"
#include "sim/mpm/matter/stretch.h"

namespace wry::mpm {

namespace {

template <class Visit, class Scalar> void for_places(const SortedSet<Scalar>& set, const Visit& visit) {
  for (const BlockRun& run : set.runs) {
    const std::size_t first = static_cast<std::size_t>(run.first_tile) * TILE_WIDTH<Scalar>;
    for (std::size_t i = 0; i < static_cast<std::size_t>(run.count); ++i)
      visit(run, first + i);
  }
}

/// Lanes past the end of a run are copies of its last particle.
template <class Scalar> void fill_up_runs(SortedSet<Scalar>& set, Channel channel) {
  constexpr std::size_t WIDTH = TILE_WIDTH<Scalar>;
  if (!set.particles.has(channel))
    return;
  for (const BlockRun& run : set.runs) {
    const std::size_t end = static_cast<std::size_t>(run.first_tile) * WIDTH + static_cast<std::size_t>(run.count);
    for (std::size_t place = end; place % WIDTH != 0; ++place) {
      for (int c = 0; c < channel_info(channel).components; ++c)
        set.particles.at(channel, place, c) = set.particles.at(channel, end - 1, c);
    }
  }
}

Vec4 quaternion_of(const Mat3& rotation) {
  const Eigen::Quaterniond q(rotation);
  return {q.w(), q.x(), q.y(), q.z()};
}

const NamedArray* find(const StateArchive& archive, const std::string& name) {
  const auto found =
      std::find_if(archive.begin(), archive.end(), [&](const NamedArray& array) { return array.name == name; });
  return found == archive.end() ? nullptr : &*found;
}

Error does_not_fit(const std::string& name) {
  return make_error(ErrorCode::io, "checkpoint: {} is missing or does not fit this shot", name);
}

constexpr std::size_t RUN_VALUES = 5; // coord, count, first tile

template <class Scalar> NamedArray archive_runs(const SortedSet<Scalar>& set, const std::string& name) {
  NamedArray array{name, {set.runs.size(), RUN_VALUES}, {}};
  array.values.reserve(set.runs.size() * RUN_VALUES);
  for (const BlockRun& run : set.runs) {
    for (const std::int64_t value : {run.coord.x, run.coord.y, run.coord.z, std::int64_t{run.count}, run.first_tile})
      array.values.push_back(static_cast<double>(value));
  }
  return array;
}

template <class Scalar> Status restore_runs(const NamedArray& array, SortedSet<Scalar>& set) {
  if (array.values.size() % RUN_VALUES != 0)
    return does_not_fit(array.name);
  set.runs.clear();
  std::int64_t tiles = 0;
  for (std::size_t i = 0; i < array.values.size(); i += RUN_VALUES) {
    const auto value = [&](std::size_t k) { return static_cast<std::int64_t>(array.values[i + k]); };
    const BlockRun run{{value(0), value(1), value(2)}, 0, static_cast<std::int32_t>(value(3)), value(4)};
    if (run.count < 1 || run.first_tile != tiles)
      return does_not_fit(array.name);
    tiles += (run.count + TILE_WIDTH<Scalar> - 1) / TILE_WIDTH<Scalar>;
    set.runs.push_back(run);
  }
  set.particles.resize(static_cast<std::size_t>(tiles));
  return {};
}

/// The gradient of a velocity field around a point: what APIC's affine field starts as. Exact for linear fields.
Mat3 slope_of(const std::function<Vec3(const Vec3&)>& field, const Vec3& point, double reach) {
  Mat3 slope;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 step = reach * Vec3::Unit(axis);
    slope.col(axis) = (field(point + step) - field(point - step)) / (2.0 * reach);
  }
  return slope;
}

} // namespace

template <class Scalar> void start_particles(const MpmBody& body, std::int64_t first_identity, SortedSet<Scalar>& set) {
  ParticleSet<Scalar>& particles = set.particles;
  const Vec4 frame = quaternion_of(body.frame);
  const std::int64_t count = body.positions->rows();
  for_places(set, [&](const BlockRun&, std::size_t place) {
    const std::int64_t identity = identity_of(particles.at(Channel::identity, place, 0));
    if (identity < first_identity)
      return;
    const Eigen::Index index = static_cast<Eigen::Index>(identity % count);
    Vec3 velocity = body.initial_velocity;
    if (body.velocity_field) {
      const Vec3 at = body.positions->row(index);
      velocity += body.velocity_field(at);
      const Mat3 slope = slope_of(body.velocity_field, at, 0.5 * std::cbrt(body.particle_volume));
      for (int c = 0; c < 9; ++c)
        particles.at(Channel::affine, place, c) = static_cast<Scalar>(slope(c / 3, c % 3));
    }
    for (int c = 0; c < 3; ++c)
      particles.at(Channel::velocity, place, c) = static_cast<Scalar>(velocity[c]);
    if (particles.has(Channel::frame)) {
      const Vec4 q = body.frames ? Vec4(body.frames->row(index)) : frame;
      for (int c = 0; c < 4; ++c)
        particles.at(Channel::frame, place, c) = static_cast<Scalar>(q[c]);
    }
    for (int c = 0; c < 6 && particles.has(Channel::second_moment); ++c)
      particles.at(Channel::second_moment, place, c) = static_cast<Scalar>(c < 3 ? body.second_moment[c] : 0.0);
    if (particles.has(Channel::stiffness_scale) && !body.stiffness_scale.empty())
      particles.at(Channel::stiffness_scale, place, 0) =
          static_cast<Scalar>(body.stiffness_scale[static_cast<std::size_t>(index)]);
    if (particles.has(Channel::strength_scale) && !body.strength_scale.empty())
      particles.at(Channel::strength_scale, place, 0) =
          static_cast<Scalar>(body.strength_scale[static_cast<std::size_t>(index)]);
  });
  for (const Channel channel : {Channel::velocity, Channel::affine, Channel::frame, Channel::second_moment,
                                Channel::stiffness_scale, Channel::strength_scale})
    fill_up_runs(set, channel);
}

template <class Scalar> StateArchive archive_state(const MpmState<Scalar>& state) {
  StateArchive archive;
  NamedArray facts{"mpm/facts", {4}, {state.time, state.max_speed, state.max_gradient, state.strayed ? 1.0 : 0.0}};
  archive.push_back(std::move(facts));
  archive.push_back({"mpm/stiffness_factor", {state.stiffness_factor.size()}, state.stiffness_factor});
  NamedArray emitted{"mpm/emitted", {state.emitted.size()}, {}};
  emitted.values.assign(state.emitted.begin(), state.emitted.end());
  archive.push_back(std::move(emitted));
  for (std::size_t b = 0; b < state.sets.size(); ++b) {
    const SortedSet<Scalar>& set = state.sets[b];
    archive.push_back(archive_runs(set, fmt::format("mpm/{}/runs", b)));
    for (int i = 0; i < CHANNEL_COUNT; ++i) {
      const Channel channel = static_cast<Channel>(i);
      const Scalar* values = set.particles.channel(channel);
      if (values == nullptr)
        continue;
      const std::size_t components = static_cast<std::size_t>(CHANNELS[i].components);
      NamedArray array{fmt::format("mpm/{}/{}", b, CHANNELS[i].name),
                       {set.particles.tiles(), components, static_cast<std::size_t>(TILE_WIDTH<Scalar>)},
                       {}};
      array.values.resize(set.particles.tiles() * components * TILE_WIDTH<Scalar>);
      for (std::size_t k = 0; k < array.values.size(); ++k)
        array.values[k] =
            channel == Channel::identity ? static_cast<double>(identity_of(values[k])) : static_cast<double>(values[k]);
      archive.push_back(std::move(array));
    }
  }
  return archive;
}

template <class Scalar> Status restore_state(const StateArchive& archive, MpmState<Scalar>& state) {
  const NamedArray* facts = find(archive, "mpm/facts");
  const NamedArray* factor = find(archive, "mpm/stiffness_factor");
  const NamedArray* emitted = find(archive, "mpm/emitted");
  if (facts == nullptr || facts->values.size() != 4)
    return does_not_fit("mpm/facts");
  if (factor == nullptr || factor->values.size() != state.sets.size())
    return does_not_fit("mpm/stiffness_factor");
  if (emitted == nullptr || emitted->values.size() != state.emitted.size())
    return does_not_fit("mpm/emitted");
  for (std::size_t b = 0; b < state.sets.size(); ++b) {
    SortedSet<Scalar>& set = state.sets[b];
    const NamedArray* runs = find(archive, fmt::format("mpm/{}/runs", b));
    if (runs == nullptr)
      return does_not_fit(fmt::format("mpm/{}/runs", b));
    if (Status status = restore_runs(*runs, set); !status)
      return status;
    for (int i = 0; i < CHANNEL_COUNT; ++i) {
      const Channel channel = static_cast<Channel>(i);
      Scalar* values = set.particles.channel(channel);
      if (!set.particles.has(channel))
        continue;
      const std::string name = fmt::format("mpm/{}/{}", b, CHANNELS[i].name);
      const NamedArray* array = find(archive, name);
      const std::size_t size =
          set.particles.tiles() * static_cast<std::size_t>(CHANNELS[i].components) * TILE_WIDTH<Scalar>;
      if (array == nullptr || array->values.size() != size)
        return does_not_fit(name);
      for (std::size_t k = 0; k < size; ++k)
        values[k] = channel == Channel::identity ? identity_bits<Scalar>(static_cast<std::int64_t>(array->values[k]))
                                                 : static_cast<Scalar>(array->values[k]);
    }
  }
  state.time = facts->values[0];
  state.max_speed = facts->values[1];
  state.max_gradient = facts->values[2];
  state.strayed = facts->values[3] != 0.0;
  state.stiffness_factor = factor->values;
  for (std::size_t i = 0; i < state.emitted.size(); ++i)
    state.emitted[i] = static_cast<std::int64_t>(emitted->values[i]);
  return {};
}

template <class Scalar>
Vec3 world_position(const ParticleSet<Scalar>& particles, const BlockRun& run, std::size_t place, double cell) {
  const std::int64_t coord[3] = {run.coord.x, run.coord.y, run.coord.z};
  Vec3 position;
  for (int axis = 0; axis < 3; ++axis)
    position[axis] = cell * (static_cast<double>(coord[axis] * BLOCK_SIDE) +
                             static_cast<double>(particles.at(Channel::position, place, axis)));
  return position;
}

namespace {

/// Q of a particle: as it is carried, or in polar frames turned with the elastic deformation.
template <class Scalar> Vec4 world_frame(const ParticleSet<Scalar>& particles, std::size_t place, FrameMode mode) {
  Vec4 frame;
  for (int c = 0; c < 4; ++c)
    frame[c] = particles.at(Channel::frame, place, c);
  if (mode != FrameMode::polar)
    return frame.normalized();
  Mat3 F;
  for (int c = 0; c < 9; ++c)
    F(c / 3, c % 3) = particles.at(Channel::deformation, place, c);
  return quaternion_product(quaternion_of(left_polar(F).rotation), frame).normalized();
}

/// Channels of what has axes: orientation (w, x, y, z), and of grains that reorient their second moment in the world
/// (xx yy zz yz zx xy).
template <class Scalar>
void add_axes(const MpmBody& body, const SortedSet<Scalar>& set, std::size_t count, FrameBody& frame) {
  if (!set.particles.has(Channel::frame))
    return;
  const bool flows = body.material.plasticity != Plasticity::none;
  const FrameMode mode = body.material.frame != FrameMode::automatic ? body.material.frame
                         : flows                                     ? FrameMode::shape
                                                                     : FrameMode::polar;
  wry::Channel orientation{"orientation", ChannelOn::particle, 4, ChannelStorage::float32,
                           std::vector<double>(count * 4)};
  wry::Channel moment{"second_moment", ChannelOn::particle, 6, ChannelStorage::float32, {}};
  const bool reorients = set.particles.has(Channel::second_moment);
  moment.values.resize(reorients ? count * 6 : 0);
  for_places(set, [&](const BlockRun&, std::size_t place) {
    const std::size_t row = static_cast<std::size_t>(identity_of(set.particles.at(Channel::identity, place, 0)));
    const Vec4 q = world_frame(set.particles, place, mode);
    for (std::size_t c = 0; c < 4; ++c)
      orientation.values[row * 4 + c] = q[static_cast<Eigen::Index>(c)];
    if (!reorients)
      return;
    constexpr int ORDER[6][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {2, 0}, {0, 1}};
    Mat3 local;
    for (int c = 0; c < 6; ++c)
      local(ORDER[c][0], ORDER[c][1]) = local(ORDER[c][1], ORDER[c][0]) =
          set.particles.at(Channel::second_moment, place, c);
    const Mat3 R = rotation_matrix(q);
    const Mat3 world = R * local * R.transpose();
    for (std::size_t c = 0; c < 6; ++c)
      moment.values[row * 6 + c] = world(ORDER[c][0], ORDER[c][1]);
  });
  frame.channels.push_back(std::move(orientation));
  if (reorients)
    frame.channels.push_back(std::move(moment));
}

} // namespace

template <class Scalar> FrameBody snapshot_body(const MpmBody& body, const SortedSet<Scalar>& set, double cell) {
  const std::size_t count = set.count();
  wry::Channel position{"position", ChannelOn::particle, 3, ChannelStorage::float64, std::vector<double>(count * 3)};
  wry::Channel velocity{"velocity", ChannelOn::particle, 3, ChannelStorage::float32, std::vector<double>(count * 3)};
  wry::Channel speed{"speed", ChannelOn::particle, 1, ChannelStorage::float32, std::vector<double>(count)};
  for_places(set, [&](const BlockRun& run, std::size_t place) {
    const std::size_t row = static_cast<std::size_t>(identity_of(set.particles.at(Channel::identity, place, 0)));
    const Vec3 at = world_position(set.particles, run, place, cell);
    double squares = 0.0;
    for (int c = 0; c < 3; ++c) {
      const double v = set.particles.at(Channel::velocity, place, c);
      position.values[row * 3 + static_cast<std::size_t>(c)] = at[c];
      velocity.values[row * 3 + static_cast<std::size_t>(c)] = v;
      squares += v * v;
    }
    speed.values[row] = std::sqrt(squares);
  });
  FrameBody frame;
  frame.name = body.name;
  frame.channels = {std::move(position), std::move(velocity), std::move(speed)};
  add_axes(body, set, count, frame);
  return frame;
}

#define WRY_INSTANTIATE(Scalar)                                                                                        \
  template void start_particles(const MpmBody&, std::int64_t, SortedSet<Scalar>&);                                     \
  template StateArchive archive_state(const MpmState<Scalar>&);                                                        \
  template Status restore_state(const StateArchive&, MpmState<Scalar>&);                                               \
  template Vec3 world_position(const ParticleSet<Scalar>&, const BlockRun&, std::size_t, double);                      \
  template FrameBody snapshot_body(const MpmBody&, const SortedSet<Scalar>&, double);
WRY_INSTANTIATE(float)
WRY_INSTANTIATE(double)
#undef WRY_INSTANTIATE

} // namespace wry::mpm
