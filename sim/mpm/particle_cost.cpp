#include <fmt/format.h>

#include "sim/mpm/mpm_simulation.h"
#include "sim/mpm/particles.h"

namespace wry::mpm {

Result<ParticleCost> particle_cost(const Material& material, Precision precision) {
  const Result<CompiledMaterial> compiled = compile_material(material);
  if (!compiled)
    return compiled.error();
  const std::size_t scalar = precision == Precision::f32 ? sizeof(float) : sizeof(double);
  ParticleCost cost;
  cost.bytes = bytes_per_particle(compiled->channels, scalar);
  const auto add = [&](Channel channel) {
    const ChannelInfo& info = channel_info(channel);
    cost.channels += fmt::format("{}{} {}", cost.channels.empty() ? "" : ", ", info.name,
                                 static_cast<std::size_t>(info.components) * scalar);
  };
  for (int i = 0; i <= static_cast<int>(LAST_BASE_CHANNEL); ++i)
    add(static_cast<Channel>(i));
  for (const Channel channel : compiled->channels)
    add(channel);
  cost.channels += fmt::format(" = {} bytes", cost.bytes);
  return cost;
}

} // namespace wry::mpm
