#include "tests/pipeline/cache_support.h"

#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>
#include <unistd.h>

namespace wry::pipeline::testing {

namespace {

const std::vector<double> STRANGE_VALUES = {
    std::bit_cast<double>(0x7ff800000000beefull), // a NaN with a payload
    std::bit_cast<double>(0xfff8dead00000001ull), -0.0,
    std::numeric_limits<double>::denorm_min(),    -std::numeric_limits<double>::denorm_min(),
    std::numeric_limits<double>::min() / 3.0,     std::numeric_limits<double>::infinity(),
    -std::numeric_limits<double>::infinity(),     std::numeric_limits<double>::max(),
};

std::vector<double> wave(std::size_t count, int number, double pitch) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i)
    values[i] = std::sin(pitch * static_cast<double>(i + 1) + number) * 1.25;
  return values;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

bool same_bits(const Channel& a, const Channel& b) {
  return a.name == b.name && a.on == b.on && a.components == b.components && a.storage == b.storage &&
         same_bits(a.values, b.values);
}

} // namespace

namespace {

/// In memory where there is room: what these tests ask of a disk does not depend on its speed.
std::filesystem::path folder_for_tests() {
  const std::filesystem::path memory = "/dev/shm";
  std::error_code failed;
  const std::filesystem::space_info space = std::filesystem::space(memory, failed);
  const bool is_roomy = !failed && space.available > (1ull << 30) && ::access(memory.c_str(), W_OK) == 0;
  return is_roomy ? memory : std::filesystem::temp_directory_path();
}

} // namespace

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (folder_for_tests() / "wry-test-XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr)
    std::abort();
  m_path = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(m_path, ignored);
}

Frame make_frame(int number, int vertices) {
  const std::size_t count = static_cast<std::size_t>(vertices);
  Frame frame;
  frame.number = number;
  frame.time = (number - 1) / 24.0;
  FrameBody body;
  body.name = "the bunny/left";
  Channel position{"position", ChannelOn::vertex, 3, ChannelStorage::float64, wave(3 * count, number, 0.37)};
  for (std::size_t i = 0; i < STRANGE_VALUES.size() && i < position.values.size(); ++i)
    position.values[position.values.size() - 1 - i] = STRANGE_VALUES[i];
  Channel speed{"speed", ChannelOn::vertex, 1, ChannelStorage::float32, wave(count, number, 0.11)};
  for (double& value : speed.values)
    value = static_cast<float>(value);
  Channel energy{"energy", ChannelOn::tet, 1, ChannelStorage::float64, {}};
  Channel total{"total", ChannelOn::global, 2, ChannelStorage::float64, {number * 0.5, -0.0}};
  body.channels = {position, speed, energy, total};
  FrameBody floor;
  floor.name = "floor";
  floor.transform(0, 3) = 0.1 * number;
  frame.bodies = {body, floor};
  return frame;
}

SceneStatic make_static() {
  SceneBody body;
  body.name = "the bunny/left";
  body.look = "rubber";
  body.rest_positions = Points::Random(5, 3);
  body.tets.resize(2, 4);
  body.tets << 0, 1, 2, 3, 1, 2, 3, 4;
  body.triangles.resize(1, 3);
  body.triangles << 2, 1, 0;
  SceneBody floor;
  floor.name = "floor";
  floor.simulated = false;
  floor.rest_positions = Points::Zero(3, 3);
  floor.triangles.resize(1, 3);
  floor.triangles << 0, 1, 2;
  SceneBody straw;
  straw.name = "straw";
  straw.kind = BodyKind::particles;
  straw.grain = {GrainShape::straw, Vec3(0.004, 0.005, 0.06)};
  return SceneStatic{{body, floor, straw}};
}

StateArchive make_state(int number) {
  std::vector<double> positions = wave(300, number, 0.7);
  std::copy(STRANGE_VALUES.begin(), STRANGE_VALUES.end(), positions.begin());
  return {{"fem/time", {}, {number / 24.0}},
          {"fem/positions", {100, 3}, positions},
          {"fem/nothing", {0, 4}, {}},
          {"fem/step", {2}, {0.01, -0.0}}};
}

bool same_bits(const Frame& a, const Frame& b) {
  if (a.number != b.number || std::memcmp(&a.time, &b.time, sizeof(double)) != 0 || a.bodies.size() != b.bodies.size())
    return false;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    const FrameBody& left = a.bodies[i];
    const FrameBody& right = b.bodies[i];
    if (left.name != right.name || left.channels.size() != right.channels.size() || left.transform != right.transform)
      return false;
    for (std::size_t c = 0; c < left.channels.size(); ++c) {
      if (!same_bits(left.channels[c], right.channels[c]))
        return false;
    }
  }
  return true;
}

bool same_bits(const StateArchive& a, const StateArchive& b) {
  if (a.size() != b.size())
    return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].name != b[i].name || a[i].shape != b[i].shape || !same_bits(a[i].values, b[i].values))
      return false;
  }
  return true;
}

bool is_made_frame(const Frame& frame, int number) {
  if (frame.bodies.empty() || frame.bodies[0].channels.size() < 2)
    return false;
  return same_bits(frame, make_frame(number, static_cast<int>(frame.bodies[0].channels[1].values.size())));
}

void spoil(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

std::string contents(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

} // namespace wry::pipeline::testing
