#pragma once

#include <string>

#include "pipeline/cache/hdf5_image.h"
#include "sim/base/result.h"
#include "sim/state/frame.h"
#include "sim/state/state_archive.h"

namespace wry::pipeline {

/// All of a simulation at the end of a frame.
struct Checkpoint {
  int frame = 0;
  double time = 0.0; ///< [s]
  StateArchive state;
};

/// A frame as the bytes of an HDF5 file: /bodies/0000 ... each with the attributes `name` and `transform`, and an array
/// per channel (rows x components) with the attribute `on`. Errors: bad_input for a channel without a proper name or
/// with a torn row; io; out_of_memory.
Result<std::string> encode_frame(const Frame& frame, const std::string& key, Compression compression);
/// The inverse. `name` is the file's, for messages. Errors: io, out_of_memory.
Result<Frame> decode_frame(std::string bytes, const std::string& name);

/// What does not change, likewise: /bodies/0000 with rest_positions, tets and triangles.
Result<std::string> encode_static(const SceneStatic& scene, const std::string& key, Compression compression);
Result<SceneStatic> decode_static(std::string bytes, const std::string& name);

/// A checkpoint: /arrays/0000 ... float64, bit for bit, each with its attribute `name`.
Result<std::string> encode_checkpoint(const Checkpoint& checkpoint, const std::string& key);
Result<Checkpoint> decode_checkpoint(std::string bytes, const std::string& name);

/// Arrays of what carried grains up to a frame, likewise; each is float32 where that keeps every bit.
Result<std::string> encode_fields(const StateArchive& fields, const std::string& key);
Result<StateArchive> decode_fields(std::string bytes, const std::string& name);

} // namespace wry::pipeline
