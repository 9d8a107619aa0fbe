#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cache/verified_folder.h"
#include "sim/base/result.h"
#include "sim/state/state_archive.h"

namespace wry::pipeline {

/// What carried the grains of a shot, a file per frame, as safe as frames. Each file carries the key of the matter that
/// it is of; those with another key count as not there.
class FieldStore {
public:
  /// Errors: cannot_write, io; bad_input without a key.
  static Result<FieldStore> open(const std::filesystem::path& folder, std::string key);

  bool has(int frame) const;
  /// What came between the frame before and this one. Errors: cannot_write, io, out_of_memory.
  Status write(int frame, const StateArchive& fields);
  /// Errors: missing_input when it is not there; io when damaged, naming the file; out_of_memory.
  Result<StateArchive> read(int frame) const;
  /// Takes away files whose bytes are not those that were written, so that they are made again. Returns what it found.
  /// Errors: cannot_write, io.
  Result<std::vector<std::string>> discard_damaged();
  /// Removes what is of other matter, or with an empty key everything. Errors: cannot_write, io.
  Status discard_all_but(const std::string& key);

private:
  FieldStore(VerifiedFolder folder, std::string key);

  VerifiedFolder m_folder;
  std::string m_key;
};

} // namespace wry::pipeline
