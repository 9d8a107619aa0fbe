#include "render/grain_cloud.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "render/drawable_scene.h"
#include "render/heat_values.h"

namespace wry::render {
namespace {

/// A number in [0, 1) from two integers: the same for the same grain on every frame and machine.
float hashed(std::uint32_t index, std::uint32_t stream) {
  std::uint32_t x = index * 0x9E3779B9u + stream * 0x85EBCA6Bu + 0x27D4EB2Fu;
  x = (x ^ (x >> 15)) * 0x2C1B3C6Du;
  x = (x ^ (x >> 12)) * 0x297A2D39u;
  x ^= x >> 15;
  return static_cast<float>(x >> 8) * (1.f / 16777216.f);
}

/// A bell of about unit spread within [-1, 1]: most grains are alike, a few are not.
float bell(std::uint32_t index, std::uint32_t stream) {
  return hashed(index, stream) + hashed(index, stream + 1) - 1.f;
}

Eigen::Vector3f varied_tint(const Look& look, std::uint32_t index) {
  const float brightness = look.colour_variation * bell(index, 10);
  const float hue = 0.5f * look.colour_variation * bell(index, 20);
  Eigen::Vector3f tint(1.f + brightness + hue, 1.f + brightness, 1.f + brightness - hue);
  return (tint / brightest_variation(look)).cwiseMax(0.f).cwiseMin(1.f);
}

Status check_rows(const Channel* channel, int components, Eigen::Index rows, const SceneBody& body, int frame_number) {
  if (channel == nullptr)
    return {};
  if (channel->components != components || channel->values.size() != static_cast<std::size_t>(rows * components))
    return make_error(ErrorCode::bad_input, "frame {}, body {}: channel {} has {} values; {} particles x {} expected",
                      frame_number, body.name, channel->name, channel->values.size(), rows, components);
  for (std::size_t i = 0; i < channel->values.size(); ++i) {
    if (!std::isfinite(channel->values[i]))
      return make_error(ErrorCode::bad_input,
                        "frame {}, body {}: {} of particle {} of {} is not a finite number; the frame is not drawn. "
                        "Check the simulation at this frame",
                        frame_number, body.name, channel->name, i / static_cast<std::size_t>(components), rows);
  }
  return {};
}

/// Channels of one cloud, each a row per particle; absent ones are nullptr.
struct CloudChannels {
  const Channel* position = nullptr;
  const Channel* orientation = nullptr;
  const Channel* size = nullptr;
  const Channel* velocity = nullptr;
  Eigen::Index count = 0;
};

Result<CloudChannels> cloud_channels(const SceneBody& body, const FrameBody& on_frame, int frame_number) {
  CloudChannels found;
  found.position = find_channel(on_frame, "position");
  if (found.position == nullptr || found.position->components != 3)
    return make_error(ErrorCode::bad_input, "frame {}, body {}: particles need a channel position of 3 components",
                      frame_number, body.name);
  found.count = static_cast<Eigen::Index>(found.position->values.size() / 3);
  found.orientation = find_channel(on_frame, "orientation");
  found.size = find_channel(on_frame, "size");
  found.velocity = find_channel(on_frame, "velocity");
  for (const auto& [channel, components] : {std::pair(found.position, 3), std::pair(found.orientation, 4),
                                            std::pair(found.size, 3), std::pair(found.velocity, 3)}) {
    if (const Status good = check_rows(channel, components, found.count, body, frame_number); !good.ok())
      return good.error();
  }
  return found;
}

Mat3 axes_of(const Channel* orientation, std::size_t i) {
  if (orientation == nullptr)
    return Mat3::Identity();
  const double* q = orientation->values.data() + 4 * i;
  const Eigen::Quaterniond quaternion(q[0], q[1], q[2], q[3]);
  return quaternion.norm() > 0.0 ? Mat3(quaternion.normalized().toRotationMatrix()) : Mat3(Mat3::Identity());
}

} // namespace

std::uint32_t surface_word(std::uint32_t look, std::uint32_t payload) {
  return ((look + 1u) << 24) | payload;
}

std::uint32_t tint_payload(const Eigen::Vector3f& colour) {
  const auto byte = [](float c) {
    return static_cast<std::uint32_t>(std::sqrt(std::clamp(c, 0.f, 1.f)) * 255.f + 0.5f);
  };
  return (byte(colour[0]) << 16) | (byte(colour[1]) << 8) | byte(colour[2]);
}

std::uint32_t heat_payload(float value) {
  if (value < -1.5f)
    return 65535u;
  if (value < -0.5f)
    return 65534u;
  return static_cast<std::uint32_t>(std::clamp(value, 0.f, 1.f) * 65533.f + 0.5f);
}

float heat_of_payload(std::uint32_t payload) {
  return payload == 65535u   ? HEAT_NOT_A_NUMBER
         : payload == 65534u ? HEAT_ABSENT
                             : static_cast<float>(payload) / 65533.f;
}

float brightest_variation(const Look& look) {
  return 1.f + 1.5f * look.colour_variation;
}

Result<GrainCloud> make_grain_cloud(const SceneBody& body, const FrameBody& on_frame, int frame_number,
                                    const Vec3& origin, const View& view, const Look& look, std::uint32_t look_row) {
  const Result<CloudChannels> channels = cloud_channels(body, on_frame, frame_number);
  if (!channels.ok())
    return channels.error();
  HeatValues heat;
  if (view.colouring == Colouring::heat) {
    Result<HeatValues> values = heat_values(*view.heat, body, on_frame);
    if (!values.ok())
      return values.error();
    heat = std::move(*values);
  }
  GrainCloud cloud;
  cloud.grains.resize(static_cast<std::size_t>(channels->count));
  for (std::size_t i = 0; i < cloud.grains.size(); ++i) {
    DrawGrain& grain = cloud.grains[i];
    const auto index = static_cast<std::uint32_t>(i);
    const double* p = channels->position->values.data() + 3 * i;
    Vec3 size = body.grain.size;
    if (channels->size != nullptr)
      size = Eigen::Map<const Vec3>(channels->size->values.data() + 3 * i);
    const double factor = 1.0 + static_cast<double>(look.size_variation * bell(index, 30));
    const Mat3 axes = axes_of(channels->orientation, i);
    for (int a = 0; a < 3; ++a) {
      grain.centre[static_cast<std::size_t>(a)] = static_cast<float>(p[a] - origin[a]);
      for (int c = 0; c < 3; ++c)
        grain.axes[static_cast<std::size_t>(a)][static_cast<std::size_t>(c)] =
            static_cast<float>(0.5 * factor * size[a] * axes(c, a));
      grain.velocity[static_cast<std::size_t>(a)] =
          channels->velocity != nullptr
              ? static_cast<float>(channels->velocity->values[3 * i + static_cast<std::size_t>(a)])
              : 0.f;
    }
    std::uint32_t payload = 0;
    if (view.colouring == Colouring::look)
      payload = tint_payload(varied_tint(look, index));
    else if (view.colouring == Colouring::heat)
      payload = heat_payload(heat.rows.empty() ? HEAT_ABSENT : heat.rows[i]);
    grain.word = surface_word(look_row, payload);
    cloud.reach = std::max(cloud.reach, static_cast<float>(0.5 * factor * size.norm()));
  }
  std::array<double, 3> extents = {body.grain.size.x(), body.grain.size.y(), body.grain.size.z()};
  std::sort(extents.begin(), extents.end());
  cloud.mean_width = static_cast<float>(std::sqrt(extents[0] * extents[1]));
  cloud.mean_volume = body.grain.size.prod();
  return cloud;
}

} // namespace wry::render
