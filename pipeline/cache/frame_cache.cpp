#include "pipeline/cache/frame_cache.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "pipeline/cache/frame_format.h"
#include "pipeline/cache/memory_guard.h"

namespace wry::pipeline {

namespace fs = std::filesystem;

namespace {

const std::string STATIC_NAME = "static.h5";

std::optional<int> frame_number(std::string_view name) {
  if (!name.ends_with(".h5"))
    return std::nullopt;
  name.remove_suffix(3);
  int number = 0;
  const auto [end, failed] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (failed != std::errc() || end != name.data() + name.size())
    return std::nullopt;
  return number;
}

Status check_image(std::string bytes, const std::string& name) {
  return or_out_of_memory(name, [&] {
    Hdf5ImageReader file(std::move(bytes), name);
    file.read_everything();
    return file.status();
  });
}

Error missing(const std::string& what, const fs::path& folder, const ManifestEntry* stale) {
  if (stale == nullptr)
    return make_error(ErrorCode::missing_input, "{} is not in {}; simulate it first (wry simulate)", what,
                      folder.string());
  return make_error(
      ErrorCode::missing_input,
      "{} in {} was made from other inputs than the shot has now (key {}); simulate it again (wry simulate)", what,
      folder.string(), stale->key);
}

} // namespace

std::string frame_file_name(int number) {
  return fmt::format("{:04}.h5", number);
}

FrameCache::FrameCache(VerifiedFolder folder, Settings settings)
    : m_folder(std::move(folder))
    , m_settings(std::move(settings)) {}

Result<FrameCache> FrameCache::open_to_write(const fs::path& folder, Settings settings) {
  if (settings.key.empty())
    return make_error(ErrorCode::bad_input, "the frames of {} need the key of their inputs", folder.string());
  Result<VerifiedFolder> opened = VerifiedFolder::open_to_write(folder, settings.faults);
  if (!opened)
    return opened.error();
  return FrameCache(std::move(*opened), std::move(settings));
}

Result<FrameCache> FrameCache::open_to_read(const fs::path& folder, const std::string& key) {
  Result<VerifiedFolder> opened = VerifiedFolder::open_to_read(folder);
  if (!opened)
    return opened.error();
  return FrameCache(std::move(*opened), Settings{key, Compression::none, {}});
}

Status FrameCache::write_static(const SceneStatic& scene) {
  const Result<std::string> bytes = or_out_of_memory(
      "the static scene", [&] { return encode_static(scene, m_settings.key, m_settings.compression); });
  if (!bytes)
    return bytes.error();
  const auto check = [](std::string on_disk) { return check_image(std::move(on_disk), STATIC_NAME); };
  return m_folder.write(STATIC_NAME, *bytes, m_settings.key, check);
}

Status FrameCache::write_frame(const Frame& frame) {
  const Result<std::string> bytes = or_out_of_memory(fmt::format("frame {}", frame.number), [&] {
    return encode_frame(frame, m_settings.key, m_settings.compression);
  });
  if (!bytes)
    return bytes.error();
  const std::string name = frame_file_name(frame.number);
  const auto check = [&name](std::string on_disk) { return check_image(std::move(on_disk), name); };
  return m_folder.write(name, *bytes, m_settings.key, check);
}

const ManifestEntry* FrameCache::current(const std::string& name) const {
  const ManifestEntry* entry = m_folder.manifest().find(name);
  return entry != nullptr && (m_settings.key.empty() || entry->key == m_settings.key) ? entry : nullptr;
}

bool FrameCache::has_static() const {
  return current(STATIC_NAME) != nullptr;
}
bool FrameCache::has_frame(int number) const {
  return current(frame_file_name(number)) != nullptr;
}

std::vector<CachedFrame> FrameCache::frames() const {
  return list(true);
}
std::vector<CachedFrame> FrameCache::stale_frames() const {
  return list(false);
}

std::vector<CachedFrame> FrameCache::list(bool with_this_key) const {
  std::vector<CachedFrame> found;
  for (const ManifestEntry& entry : m_folder.manifest().entries()) {
    const std::optional<int> number = frame_number(entry.name);
    const bool has_this_key = m_settings.key.empty() || entry.key == m_settings.key;
    if (number && has_this_key == with_this_key)
      found.push_back({*number, entry.size, entry.sha256, entry.key});
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  return found;
}

Result<std::string> FrameCache::read(const std::string& name, const std::string& what) const {
  if (current(name) == nullptr)
    return missing(what, m_folder.path(), m_folder.manifest().find(name));
  return m_folder.read(name);
}

Result<SceneStatic> FrameCache::read_static() const {
  Result<std::string> bytes = read(STATIC_NAME, "the static scene");
  if (!bytes)
    return bytes.error();
  const std::string path = (m_folder.path() / STATIC_NAME).string();
  return or_out_of_memory(path, [&] { return decode_static(*std::move(bytes), path); });
}

Result<Frame> FrameCache::read_frame(int number) const {
  const std::string name = frame_file_name(number);
  const std::string path = (m_folder.path() / name).string();
  Result<std::string> bytes = read(name, fmt::format("frame {}", number));
  if (!bytes)
    return bytes.error();
  Result<Frame> frame = or_out_of_memory(path, [&] { return decode_frame(*std::move(bytes), path); });
  if (frame && frame->number != number)
    return make_error(ErrorCode::io, "{} is damaged or not ours: it says that it is frame {}", path, frame->number);
  return frame;
}

Status FrameCache::discard_after(int number) {
  const std::vector<ManifestEntry> entries = m_folder.manifest().entries();
  for (const ManifestEntry& entry : entries) {
    const std::optional<int> entry_number = frame_number(entry.name);
    if (!entry_number || *entry_number <= number)
      continue;
    if (Status removed = m_folder.remove(entry.name); !removed)
      return removed;
  }
  return {};
}

Status FrameCache::discard_all() {
  const std::vector<ManifestEntry> entries = m_folder.manifest().entries();
  for (const ManifestEntry& entry : entries) {
    if (Status removed = m_folder.remove(entry.name); !removed)
      return removed;
  }
  return {};
}

} // namespace wry::pipeline
