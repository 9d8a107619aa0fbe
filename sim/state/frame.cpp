#include "sim/state/frame.h"

namespace wry {

const Channel* find_channel(const FrameBody& body, const std::string& name) {
  for (const Channel& channel : body.channels) {
    if (channel.name == name)
      return &channel;
  }
  return nullptr;
}

} // namespace wry
