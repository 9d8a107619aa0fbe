#include "render/heat_values.h"

#include <algorithm>
#include <cmath>

#include "render/drawable_scene.h"

namespace wry::render {
namespace {

double scalar(const Channel& channel, std::size_t row, int component) {
  const std::size_t width = static_cast<std::size_t>(channel.components);
  const double* first = channel.values.data() + row * width;
  if (component >= 0)
    return first[component];
  if (width == 1)
    return first[0];
  double sum = 0.0;
  for (std::size_t c = 0; c < width; ++c)
    sum += first[c] * first[c];
  return std::sqrt(sum);
}

} // namespace

Result<HeatValues> heat_values(const HeatStyle& style, const SceneBody& body, const FrameBody& on_frame) {
  HeatValues heat;
  const Channel* channel = find_channel(on_frame, style.channel);
  if (channel == nullptr)
    return heat;
  if (channel->on == ChannelOn::global)
    return make_error(ErrorCode::bad_input, "body {}: channel {} is one value for the body and cannot be a heat view",
                      body.name, style.channel);
  const Channel* position = find_channel(on_frame, "position");
  const Eigen::Index rows = channel->on == ChannelOn::tet ? body.tets.rows()
                            : body.kind == BodyKind::particles && position != nullptr
                                ? static_cast<Eigen::Index>(position->values.size() / 3)
                                : body.rest_positions.rows();
  if (channel->components < 1 || channel->values.size() != static_cast<std::size_t>(rows * channel->components))
    return make_error(ErrorCode::bad_input, "body {}: channel {} has {} values; {} rows of {} were expected", body.name,
                      style.channel, channel->values.size(), rows, channel->components);
  if (style.component >= channel->components)
    return make_error(ErrorCode::bad_input, "body {}: channel {} has {} components; component {} is not there",
                      body.name, style.channel, channel->components, style.component);
  heat.on = channel->on;
  heat.rows.resize(static_cast<std::size_t>(rows));
  for (std::size_t i = 0; i < heat.rows.size(); ++i) {
    const double value = scalar(*channel, i, style.component);
    heat.rows[i] = std::isfinite(value)
                       ? static_cast<float>(std::clamp((value - style.low) / (style.high - style.low), 0.0, 1.0))
                       : HEAT_NOT_A_NUMBER;
  }
  return heat;
}

} // namespace wry::render
