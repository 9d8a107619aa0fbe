#include "pipeline/cache/checkpoints.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "pipeline/cache/memory_guard.h"

namespace wry::pipeline {

namespace fs = std::filesystem;

namespace {

std::string file_name(int frame) {
  return fmt::format("{:04}.h5", frame);
}

int frame_of(const ManifestEntry& entry) {
  int frame = 0;
  std::from_chars(entry.name.data(), entry.name.data() + entry.name.size(), frame);
  return frame;
}

Result<Checkpoint> decode(std::string bytes, const std::string& name) {
  return or_out_of_memory(name, [&] { return decode_checkpoint(std::move(bytes), name); });
}

} // namespace

CheckpointStore::CheckpointStore(VerifiedFolder folder, Settings settings)
    : m_folder(std::move(folder))
    , m_settings(std::move(settings)) {}

Result<CheckpointStore> CheckpointStore::open(const fs::path& folder, Settings settings) {
  if (settings.key.empty())
    return make_error(ErrorCode::bad_input, "the checkpoints of {} need the key of their inputs", folder.string());
  Result<VerifiedFolder> opened = VerifiedFolder::open_to_write(folder, settings.faults);
  if (!opened)
    return opened.error();
  return CheckpointStore(std::move(*opened), std::move(settings));
}

Status CheckpointStore::write(const StateArchive& state, int frame, double time) {
  const std::string name = file_name(frame);
  const Result<std::string> bytes = or_out_of_memory(fmt::format("the checkpoint of frame {}", frame), [&] {
    return encode_checkpoint(Checkpoint{frame, time, state}, m_settings.key);
  });
  if (!bytes)
    return bytes.error();
  const auto check = [&name](std::string on_disk) -> Status {
    const Result<Checkpoint> read_back = decode(std::move(on_disk), name);
    return read_back ? Status() : Status(read_back.error());
  };
  if (Status written = m_folder.write(name, *bytes, m_settings.key, check); !written)
    return written;
  return prune();
}

Status CheckpointStore::prune() {
  const std::vector<ManifestEntry> entries = m_folder.manifest().entries();
  int seen = 0;
  // Entries stand in the order of writing: the last ones are those written last, not those with the highest frames.
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
    if (entry->key == m_settings.key && ++seen <= m_settings.keep_last)
      continue;
    if (m_settings.keep_every > 0 && frame_of(*entry) % m_settings.keep_every == 0)
      continue;
    if (Status removed = m_folder.remove(entry->name); !removed)
      return removed;
  }
  return {};
}

Result<CheckpointStore::Found> CheckpointStore::latest_at_or_before(int frame, CheckpointKey key) const {
  std::vector<ManifestEntry> candidates = m_folder.manifest().entries();
  std::erase_if(candidates, [&](const ManifestEntry& entry) {
    return frame_of(entry) > frame || (key == CheckpointKey::same && entry.key != m_settings.key);
  });
  std::sort(candidates.begin(), candidates.end(),
            [](const auto& a, const auto& b) { return frame_of(a) > frame_of(b); });
  Found found;
  for (const ManifestEntry& entry : candidates) {
    Result<std::string> bytes = m_folder.read(entry.name);
    Result<Checkpoint> read =
        bytes ? decode(*std::move(bytes), (m_folder.path() / entry.name).string()) : Result<Checkpoint>(bytes.error());
    if (read && read->frame == frame_of(entry)) {
      found.checkpoint = *std::move(read);
      found.key = entry.key;
      return found;
    }
    if (!read && read.error().code == ErrorCode::out_of_memory)
      return read.error();
    found.warnings.push_back(fmt::format("the checkpoint of frame {} cannot be used, going on from an earlier one: {}",
                                         frame_of(entry), read ? "it is of another frame" : read.error().message));
  }
  return found;
}

std::vector<int> CheckpointStore::frames() const {
  std::vector<int> frames;
  for (const ManifestEntry& entry : m_folder.manifest().entries()) {
    if (entry.key == m_settings.key)
      frames.push_back(frame_of(entry));
  }
  std::sort(frames.begin(), frames.end());
  return frames;
}

Status CheckpointStore::discard_all() {
  const std::vector<ManifestEntry> entries = m_folder.manifest().entries();
  for (const ManifestEntry& entry : entries) {
    if (Status removed = m_folder.remove(entry.name); !removed)
      return removed;
  }
  return {};
}

} // namespace wry::pipeline
