#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cache/hdf5_image.h"
#include "pipeline/cache/verified_folder.h"
#include "sim/base/result.h"
#include "sim/state/frame.h"

namespace wry::pipeline {

/// A finished frame in the cache.
struct CachedFrame {
  int number = 0;
  std::uint64_t size = 0; ///< [bytes]
  std::string sha256;
  std::string key;
};

/// The frames of a shot on disk: static.h5 and one file per frame, 0001.h5 ..., with a manifest (see VerifiedFolder).
///
/// Every file carries the key of the inputs it was made from. Frames with another key are stale: they are not listed,
/// not read, and replaced as the run comes to them. Reading is safe from several threads and beside a writing process.
class FrameCache {
public:
  struct Settings {
    std::string
        key; ///< one word, for example a SHA-256 of everything that the frames depend on; to read, empty takes any
    Compression compression = Compression::none;
    FaultHook faults; ///< tests only
  };

  /// Errors: cannot_write (found before anything is simulated), io; bad_input without a key.
  static Result<FrameCache> open_to_write(const std::filesystem::path& folder, Settings settings);
  /// Errors: missing_input when there is no cache, io.
  static Result<FrameCache> open_to_read(const std::filesystem::path& folder, const std::string& key = {});

  /// Errors: cannot_write, io, bad_input, out_of_memory. A frame that could not be written is not there.
  Status write_static(const SceneStatic& scene);
  Status write_frame(const Frame& frame);

  bool has_static() const;
  bool has_frame(int number) const;
  /// Finished frames with this key, by number.
  std::vector<CachedFrame> frames() const;
  /// Frames that were made from other inputs, by number.
  std::vector<CachedFrame> stale_frames() const;

  /// Errors: missing_input when it is not there or stale; io when damaged, naming the file; out_of_memory.
  Result<SceneStatic> read_static() const;
  Result<Frame> read_frame(int number) const;

  /// Sees what a running writer has finished meanwhile. Errors: io.
  Status refresh() { return m_folder.refresh(); }
  /// Removes the frames after `number`, of any key. Errors: cannot_write, io.
  Status discard_after(int number);
  /// Removes everything, for --fresh. Errors: cannot_write, io.
  Status discard_all();

private:
  FrameCache(VerifiedFolder folder, Settings settings);
  const ManifestEntry* current(const std::string& name) const;
  std::vector<CachedFrame> list(bool with_this_key) const;
  Result<std::string> read(const std::string& name, const std::string& what) const;

  VerifiedFolder m_folder;
  Settings m_settings;
};

/// "0042.h5"
std::string frame_file_name(int number);

} // namespace wry::pipeline
