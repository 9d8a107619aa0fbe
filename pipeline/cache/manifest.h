#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/cache/atomic_file.h"
#include "sim/base/result.h"

namespace wry::pipeline {

/// A finished file of a folder, as its manifest knows it.
struct ManifestEntry {
  std::string name;       ///< file name in the folder
  std::uint64_t size = 0; ///< [bytes]
  std::string sha256;     ///< of the whole file
  std::string key;        ///< of the inputs the file was made from
};

/// The list of the finished files of a folder: a text file that only grows while a run lives.
///
/// Each line says `have NAME SIZE SHA256 KEY` or `gone NAME`, and ends with a check sum of itself; the last line about
/// a name counts. A line that a kill or a power cut tore at the end is ignored and cut off by the next writer, a bad
/// line before the end is damage. One writer (see run/lock.h), any number of readers.
class Manifest {
public:
  /// Reads the manifest of `folder`; none there is an empty one. Errors: io when it is damaged, with the line.
  static Result<Manifest> load(const std::filesystem::path& folder);

  /// Entries in the order in which they were last written.
  const std::vector<ManifestEntry>& entries() const { return m_entries; }
  /// The entry of that name, or nullptr.
  const ManifestEntry* find(std::string_view name) const;
  /// Whether the last line was torn.
  bool has_torn_end() const { return m_good_bytes < m_file_bytes; }

  /// Cuts off a torn last line. Writers call it first. Errors: cannot_write, io.
  Status repair();
  /// Records a finished file. Errors: cannot_write, io; the record is then not there. bad_input for a name or key with
  /// spaces.
  Status add(const ManifestEntry& entry, const FaultHook& faults = {});
  /// Records that a file is about to go away or to be replaced. Errors: cannot_write, io.
  Status remove(std::string_view name, const FaultHook& faults = {});

  std::filesystem::path path() const;

private:
  Status append(const std::string& fields, const FaultHook& faults);
  bool take_line(std::string_view line);
  void forget(std::string_view name);

  std::filesystem::path m_folder;
  std::vector<ManifestEntry> m_entries;
  std::uint64_t m_good_bytes = 0;
  std::uint64_t m_file_bytes = 0;
};

} // namespace wry::pipeline
