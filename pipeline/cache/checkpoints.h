#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/cache/frame_format.h"
#include "pipeline/cache/verified_folder.h"
#include "sim/base/result.h"

namespace wry::pipeline {

/// Which checkpoints may be gone on from.
enum class CheckpointKey {
  same, ///< only those made from the inputs that the shot has now
  any,  ///< also older ones: after an edit that the user says concerns later frames only
};

/// The checkpoints of a shot: all of a simulation's state, float64, bit for bit, in files as safe as frames.
class CheckpointStore {
public:
  struct Settings {
    std::string key;    ///< of the inputs, one word
    int keep_every = 0; ///< frames whose number is a multiple of it are kept for good; 0: none
    FaultHook faults;   ///< tests only
    int keep_last = 2;  ///< of those written last with this key; at least 1
  };

  /// A checkpoint, if there is one, and what had to be passed over to get to it.
  struct Found {
    std::optional<Checkpoint> checkpoint;
    std::string key;                   ///< of the inputs it was made from
    std::vector<std::string> warnings; ///< one for each damaged checkpoint that was later
  };

  /// Errors: cannot_write, io; bad_input without a key.
  static Result<CheckpointStore> open(const std::filesystem::path& folder, Settings settings);

  /// Writes one and then removes those no longer kept: all but the `keep_last` written last with this key and
  /// every `keep_every`th. Errors: cannot_write, io, bad_input, out_of_memory; older checkpoints are then still there.
  Status write(const StateArchive& state, int frame, double time);

  /// The latest whole checkpoint at or before `frame`; a damaged one is passed over with a warning. Errors:
  /// out_of_memory.
  Result<Found> latest_at_or_before(int frame, CheckpointKey key = CheckpointKey::same) const;

  /// Frames that have a checkpoint with this key, in order.
  std::vector<int> frames() const;
  /// Removes every checkpoint, for --fresh. Errors: cannot_write, io.
  Status discard_all();

private:
  CheckpointStore(VerifiedFolder folder, Settings settings);
  Status prune();

  VerifiedFolder m_folder;
  Settings m_settings;
};

} // namespace wry::pipeline
