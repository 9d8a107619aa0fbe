#include "pipeline/cache/verified_folder.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "pipeline/cache/sha256.h"

namespace wry::pipeline {

namespace fs = std::filesystem;

namespace {

constexpr int MOST_READS = 5; ///< of one file, while a writer replaces it

Error damaged(const fs::path& path, std::string_view how) {
  return make_error(ErrorCode::io, "{} is damaged: {}; remove it and run again to make it anew", path.string(), how);
}

Status compare(const fs::path& path, const ManifestEntry& entry, std::string_view bytes) {
  if (bytes.size() != entry.size)
    return damaged(path, fmt::format("it has {} bytes, the manifest says {}", bytes.size(), entry.size));
  if (const std::string sum = sha256_of_bytes(bytes); sum != entry.sha256)
    return damaged(path, fmt::format("its SHA-256 is {}, the manifest says {}", sum, entry.sha256));
  return {};
}

Result<std::string> read_and_compare(const fs::path& path, const ManifestEntry& entry) {
  Result<std::string> bytes = read_whole_file(path);
  if (!bytes && bytes.error().code == ErrorCode::missing_input)
    return make_error(ErrorCode::io, "{} is gone, but the manifest names it; run again to make it anew", path.string());
  if (!bytes)
    return bytes;
  if (Status same = compare(path, entry, *bytes); !same)
    return same.error();
  return bytes;
}

bool is_aside(const std::string& name) {
  return name.ends_with(ASIDE_SUFFIX);
}

Result<std::vector<std::string>> file_names(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code failed;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed))
    names.push_back(entry->path().filename().string());
  if (failed)
    return make_error(failed == std::errc::no_such_file_or_directory ? ErrorCode::missing_input : ErrorCode::io,
                      "cannot read the folder {}: {}", folder.string(), failed.message());
  std::sort(names.begin(), names.end());
  return names;
}

} // namespace

VerifiedFolder::VerifiedFolder(fs::path folder, Manifest manifest, FaultHook faults)
    : m_folder(std::move(folder))
    , m_manifest(std::move(manifest))
    , m_faults(std::move(faults)) {}

Result<VerifiedFolder> VerifiedFolder::open_to_write(const fs::path& folder, FaultHook faults) {
  if (Status ready = prepare_folder(folder); !ready)
    return ready.error();
  Result<VerifiedFolder> opened = open_to_read(folder);
  if (!opened)
    return opened;
  opened->m_faults = std::move(faults);
  if (Status repaired = opened->m_manifest.repair(); !repaired)
    return repaired.error();
  const Result<std::vector<std::string>> names = file_names(folder);
  if (!names)
    return names.error();
  for (const std::string& name : *names) {
    if (!is_aside(name))
      continue;
    if (Status removed = remove_file(folder / name); !removed)
      return removed.error();
  }
  return opened;
}

Result<VerifiedFolder> VerifiedFolder::open_to_read(const fs::path& folder) {
  std::error_code failed;
  if (!fs::is_directory(folder, failed))
    return make_error(ErrorCode::missing_input, "there is no folder {}", folder.string());
  Result<Manifest> manifest = Manifest::load(folder);
  if (!manifest)
    return manifest.error();
  return VerifiedFolder(folder, std::move(*manifest), {});
}

Status VerifiedFolder::refresh() {
  Result<Manifest> manifest = Manifest::load(m_folder);
  if (!manifest)
    return manifest.error();
  m_manifest = std::move(*manifest);
  return {};
}

Status VerifiedFolder::write(const std::string& name, std::string_view bytes, const std::string& key,
                             const Check& check) {
  const fs::path target = m_folder / name;
  const fs::path aside = aside_of(target);
  const ManifestEntry entry{name, bytes.size(), sha256_of_bytes(bytes), key};
  if (Status written = write_synced(aside, bytes, m_faults); !written)
    return written;
  Result<std::string> on_disk = read_and_compare(aside, entry);
  Status good = on_disk ? check(*std::move(on_disk)) : Status(on_disk.error());
  // Only now: a frame that could not be written leaves the one it would have replaced.
  if (good)
    good = m_manifest.remove(name, m_faults);
  if (!good) {
    static_cast<void>(remove_file(aside));
    return good;
  }
  if (Status published = publish(aside, target, m_faults); !published)
    return published;
  return m_manifest.add(entry, m_faults);
}

Status VerifiedFolder::remove(const std::string& name) {
  if (Status removed = m_manifest.remove(name, m_faults); !removed)
    return removed;
  return remove_file(m_folder / name, m_faults);
}

Result<std::string> VerifiedFolder::read(const std::string& name) const {
  Manifest manifest = m_manifest;
  for (int attempt = 1;; ++attempt) {
    const ManifestEntry* entry = manifest.find(name);
    if (entry == nullptr)
      return make_error(ErrorCode::missing_input, "{} is not in the manifest of its folder",
                        (m_folder / name).string());
    Result<std::string> bytes = read_and_compare(m_folder / name, *entry);
    if (bytes || attempt == MOST_READS)
      return bytes;
    Result<Manifest> newer = Manifest::load(m_folder);
    if (!newer)
      return newer.error();
    const ManifestEntry* newer_entry = newer->find(name);
    if (newer_entry != nullptr && newer_entry->sha256 == entry->sha256)
      return bytes;
    manifest = std::move(*newer);
  }
}

bool is_damage(FolderFinding::Kind kind) {
  return kind == FolderFinding::Kind::damaged || kind == FolderFinding::Kind::missing;
}

Result<FolderReport> check_folder(const fs::path& folder) {
  const Result<std::vector<std::string>> names = file_names(folder);
  if (!names)
    return names.error();
  const Result<Manifest> manifest = Manifest::load(folder);
  if (!manifest)
    return manifest.error();
  using Kind = FolderFinding::Kind;
  FolderReport report;
  if (manifest->has_torn_end())
    report.findings.push_back(
        {Kind::torn_manifest, manifest->path().filename().string(),
         manifest->path().string() + ": its last line is half written; the next run cuts it off"});
  std::vector<ManifestEntry> entries = manifest->entries();
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  for (const ManifestEntry& entry : entries) {
    const Result<std::string> bytes = read_and_compare(folder / entry.name, entry);
    if (bytes) {
      ++report.good_files;
      report.good_bytes += entry.size;
      continue;
    }
    const bool is_there = std::binary_search(names->begin(), names->end(), entry.name);
    report.findings.push_back({is_there ? Kind::damaged : Kind::missing, entry.name, bytes.error().message});
  }
  for (const std::string& name : *names) {
    const std::string path = (folder / name).string();
    if (is_aside(name))
      report.findings.push_back({Kind::unfinished, name, path + " was left unfinished; the next run removes it"});
    else if (name != manifest->path().filename() && manifest->find(name) == nullptr)
      report.findings.push_back({Kind::orphan, name, path + " is not in the manifest: no reader takes it"});
  }
  return report;
}

} // namespace wry::pipeline
