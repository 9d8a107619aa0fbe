#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "sim/state/frame.h"
#include "sim/state/state_archive.h"

namespace wry::pipeline::testing {

/// A new folder, in memory if there is room, that goes away with the test.
class TemporaryFolder {
public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return m_path; }

private:
  std::filesystem::path m_path;
};

/// A frame of two bodies, one with channels of every kind, that depends on the number alone. Its last values are NaNs
/// with a payload, negative zeros, denormals and infinities.
Frame make_frame(int number, int vertices);

/// Whether this is make_frame(number, v) for the number of vertices that it has.
bool is_made_frame(const Frame& frame, int number);

/// Two bodies, the first with tets.
SceneStatic make_static();

/// Three arrays, of rank 0, 1 and 2, that depend on the number alone, with the same strange values.
StateArchive make_state(int number);

/// Whether two frames agree in every name and in every bit of every value.
bool same_bits(const Frame& a, const Frame& b);
bool same_bits(const StateArchive& a, const StateArchive& b);

/// Overwrites a file as a damaged disk would.
void spoil(const std::filesystem::path& path, const std::string& bytes);

/// Everything in a file.
std::string contents(const std::filesystem::path& path);

} // namespace wry::pipeline::testing
