#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cache/manifest.h"
#include "sim/base/result.h"

namespace wry::pipeline {

/// A folder of files of which each is right or not there: frames and checkpoints live in one.
///
/// A file is written aside, read back and compared, synced, renamed, and only then named in the manifest with its size
/// and SHA-256. One that is replaced is first taken out of the manifest. So at any instant, also under kills and on a
/// full disk, the manifest names only whole files. One writer (see run/lock.h); any number of readers beside it.
class VerifiedFolder {
public:
  /// Looks at the bytes that were read back from the disk, before they count.
  using Check = std::function<Status(std::string bytes)>;

  /// Makes the folder, shows that it can be written, repairs the manifest and removes what a kill left unfinished.
  /// Errors: cannot_write, io.
  static Result<VerifiedFolder> open_to_write(const std::filesystem::path& folder, FaultHook faults = {});
  /// Errors: missing_input when the folder is not there, io.
  static Result<VerifiedFolder> open_to_read(const std::filesystem::path& folder);

  const std::filesystem::path& path() const { return m_folder; }
  const Manifest& manifest() const { return m_manifest; }
  /// Reads the manifest again: a writer may have gone on. Errors: io.
  Status refresh();

  /// Puts a file in place; `check` looks at what was read back. Errors: cannot_write, io; the file is then not there.
  Status write(const std::string& name, std::string_view bytes, const std::string& key, const Check& check);
  /// Takes a file out of the manifest, then away. Errors: cannot_write, io.
  Status remove(const std::string& name);

  /// The bytes of a file, with the size and SHA-256 that the manifest says. A file that a writer replaces meanwhile is
  /// read anew. Errors: missing_input when the manifest does not name it, io when it is damaged or gone.
  Result<std::string> read(const std::string& name) const;

private:
  explicit VerifiedFolder(std::filesystem::path folder, Manifest manifest, FaultHook faults);

  std::filesystem::path m_folder;
  Manifest m_manifest;
  FaultHook m_faults;
};

/// Something about a folder that is not as it should be.
struct FolderFinding {
  enum class Kind {
    damaged,       ///< size or SHA-256 differ from the manifest
    missing,       ///< in the manifest, not in the folder
    orphan,        ///< in the folder, not in the manifest: a kill came between the two; it will be made again
    unfinished,    ///< written aside and left there by a kill
    torn_manifest, ///< the last line of the manifest is half written; what it was about will be made again
  };
  Kind kind = Kind::damaged;
  std::string name;
  std::string message; ///< for the user
};

/// Whether a finding is a loss, rather than what a kill may leave behind.
bool is_damage(FolderFinding::Kind kind);

/// What `wry check DIR` says of one folder.
struct FolderReport {
  std::size_t good_files = 0;
  std::uint64_t good_bytes = 0;
  std::vector<FolderFinding> findings; ///< in the order of the file names
};

/// Compares every file of a folder with its manifest, SHA-256 included. Errors: missing_input, io when the manifest
/// itself is damaged.
Result<FolderReport> check_folder(const std::filesystem::path& folder);

} // namespace wry::pipeline
