#include "pipeline/run/resources.h"

#include <algorithm>

#include <fmt/format.h>

#include "pipeline/report/readable.h"

namespace wry::pipeline {

namespace {

/// The limit that leaves least; nullptr: none is known.
const Room* tightest(const std::vector<Room>& rooms) {
  const auto least =
      std::min_element(rooms.begin(), rooms.end(), [](const Room& a, const Room& b) { return a.bytes < b.bytes; });
  return least == rooms.end() ? nullptr : &*least;
}

/// What takes most of it and how that is lowered: "the 48510 particles of body load take 2 GiB of it: ..."
std::string advice(const CostEstimate& cost, std::uint64_t CostShare::*bytes) {
  const auto most = std::max_element(cost.shares.begin(), cost.shares.end(),
                                     [&](const CostShare& a, const CostShare& b) { return a.*bytes < b.*bytes; });
  if (most == cost.shares.end() || (*most).*bytes == 0)
    return {};
  return fmt::format("{} take about {} of it: {}; ", most->what, human_bytes(double((*most).*bytes)), most->cure);
}

} // namespace

Status require_resources(const std::string& shot, const CostEstimate& cost, double frame_count,
                         const Machine& machine) {
  const auto require = [&](const char* of_what, std::uint64_t needed, const Room* room, std::uint64_t CostShare::*bytes,
                           ErrorCode code, const char* otherwise) -> Status {
    if (room == nullptr || needed <= room->bytes)
      return {};
    return make_error(code,
                      "{}: needs about {} of {}, but only {} of {} can be had; {}{}--ignore-limits runs all the same",
                      shot, human_bytes(double(needed)), of_what, human_bytes(double(room->bytes)), room->whose,
                      advice(cost, bytes), otherwise);
  };
  if (Status status = require("memory", cost.memory_bytes, tightest(machine.memory), &CostShare::memory_bytes,
                              ErrorCode::out_of_memory, "");
      !status)
    return status;
  return require("disk", cost.disk_bytes(frame_count), tightest(machine.disk), &CostShare::disk_bytes,
                 ErrorCode::cannot_write, "fewer --frames need less, --out chooses another disk; ");
}

} // namespace wry::pipeline
