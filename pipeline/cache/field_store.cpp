#include "pipeline/cache/field_store.h"

#include <utility>

#include "pipeline/cache/frame_cache.h"
#include "pipeline/cache/frame_format.h"
#include "pipeline/cache/memory_guard.h"

namespace wry::pipeline {

FieldStore::FieldStore(VerifiedFolder folder, std::string key)
    : m_folder(std::move(folder))
    , m_key(std::move(key)) {}

Result<FieldStore> FieldStore::open(const std::filesystem::path& folder, std::string key) {
  if (key.empty())
    return make_error(ErrorCode::bad_input, "the fields of {} need the key of their inputs", folder.string());
  Result<VerifiedFolder> opened = VerifiedFolder::open_to_write(folder);
  if (!opened)
    return opened.error();
  return FieldStore(std::move(*opened), std::move(key));
}

bool FieldStore::has(int frame) const {
  const ManifestEntry* entry = m_folder.manifest().find(frame_file_name(frame));
  return entry != nullptr && entry->key == m_key;
}

Status FieldStore::write(int frame, const StateArchive& fields) {
  const std::string name = frame_file_name(frame);
  const Result<std::string> bytes =
      or_out_of_memory(fmt::format("the fields of frame {}", frame), [&] { return encode_fields(fields, m_key); });
  if (!bytes)
    return bytes.error();
  const auto check = [&name](std::string on_disk) -> Status {
    const Result<StateArchive> read_back =
        or_out_of_memory(name, [&] { return decode_fields(std::move(on_disk), name); });
    return read_back ? Status() : Status(read_back.error());
  };
  return m_folder.write(name, *bytes, m_key, check);
}

Result<StateArchive> FieldStore::read(int frame) const {
  const std::string name = frame_file_name(frame);
  if (!has(frame))
    return make_error(ErrorCode::missing_input, "{} has no fields of frame {} of this matter", m_folder.path().string(),
                      frame);
  Result<std::string> bytes = m_folder.read(name);
  if (!bytes)
    return bytes.error();
  const std::string path = (m_folder.path() / name).string();
  return or_out_of_memory(path, [&] { return decode_fields(*std::move(bytes), path); });
}

Result<std::vector<std::string>> FieldStore::discard_damaged() {
  const Result<FolderReport> report = check_folder(m_folder.path());
  if (!report)
    return report.error();
  std::vector<std::string> found;
  for (const FolderFinding& finding : report->findings) {
    if (!is_damage(finding.kind))
      continue;
    if (Status removed = m_folder.remove(finding.name); !removed)
      return removed.error();
    found.push_back(finding.message);
  }
  return found;
}

Status FieldStore::discard_all_but(const std::string& key) {
  const std::vector<ManifestEntry> entries = m_folder.manifest().entries();
  for (const ManifestEntry& entry : entries) {
    if (!key.empty() && entry.key == key)
      continue;
    if (Status removed = m_folder.remove(entry.name); !removed)
      return removed;
  }
  return {};
}

} // namespace wry::pipeline
