#include "pipeline/cache/manifest.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <sstream>
#include <unistd.h>

#include "pipeline/cache/file_error.h"
#include "pipeline/cache/sha256.h"

namespace wry::pipeline {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view FILE_NAME = "manifest";
constexpr std::size_t CHECK_DIGITS = 16;

std::string check_sum(std::string_view fields) {
  return sha256_of_bytes(fields).substr(0, CHECK_DIGITS);
}

bool is_one_word(std::string_view text) {
  const auto is_plain = [](char c) { return c > ' ' && c < 127 && c != '/'; };
  return !text.empty() && std::all_of(text.begin(), text.end(), is_plain);
}

/// The fields of a line without its check sum; empty when the sum does not fit.
std::string_view checked_fields(std::string_view line) {
  const std::size_t space = line.rfind(' ');
  if (space == std::string_view::npos || check_sum(line.substr(0, space)) != line.substr(space + 1))
    return {};
  return line.substr(0, space);
}

} // namespace

fs::path Manifest::path() const {
  return m_folder / FILE_NAME;
}

const ManifestEntry* Manifest::find(std::string_view name) const {
  const auto found = std::find_if(m_entries.begin(), m_entries.end(), [&](const auto& e) { return e.name == name; });
  return found == m_entries.end() ? nullptr : &*found;
}

void Manifest::forget(std::string_view name) {
  std::erase_if(m_entries, [&](const ManifestEntry& entry) { return entry.name == name; });
}

bool Manifest::take_line(std::string_view line) {
  std::istringstream fields{std::string(checked_fields(line))};
  std::string verb;
  ManifestEntry entry;
  if (!(fields >> verb >> entry.name))
    return false;
  if (verb == "have" && !(fields >> entry.size >> entry.sha256 >> entry.key))
    return false;
  if (verb != "have" && verb != "gone")
    return false;
  forget(entry.name);
  if (verb == "have")
    m_entries.push_back(std::move(entry));
  return true;
}

Result<Manifest> Manifest::load(const fs::path& folder) {
  Manifest manifest;
  manifest.m_folder = folder;
  const Result<std::string> text = read_whole_file(manifest.path());
  if (!text && text.error().code == ErrorCode::missing_input)
    return manifest;
  if (!text)
    return text.error();
  manifest.m_file_bytes = text->size();
  std::string_view rest = *text;
  for (int number = 1; !rest.empty(); ++number) {
    const std::size_t end = rest.find('\n');
    if (end == std::string_view::npos)
      break;
    if (!manifest.take_line(rest.substr(0, end)))
      return make_error(ErrorCode::io,
                        "{}:{}: this line is damaged (its check sum does not fit); run again with --fresh, or put the "
                        "folder back from a backup",
                        manifest.path().string(), number);
    manifest.m_good_bytes += end + 1;
    rest.remove_prefix(end + 1);
  }
  return manifest;
}

Status Manifest::repair() {
  if (!has_torn_end())
    return {};
  const bool is_cut = ::truncate(path().c_str(), static_cast<off_t>(m_good_bytes)) == 0;
  if (!is_cut && !(errno == ENOENT && m_good_bytes == 0))
    return write_error("repair", path(), errno);
  m_file_bytes = m_good_bytes;
  return {};
}

Status Manifest::append(const std::string& fields, const FaultHook& faults) {
  if (Status repaired = repair(); !repaired)
    return repaired;
  const bool is_new = m_file_bytes == 0;
  const std::string line = fmt::format("{} {}\n", fields, check_sum(fields));
  Status appended = append_synced(path(), line, faults);
  if (!appended) {
    // A full disk may have taken half the line: cut it off now, or at the latest before the next one.
    m_file_bytes = m_good_bytes + 1;
    static_cast<void>(repair());
    return appended;
  }
  m_good_bytes += line.size();
  m_file_bytes = m_good_bytes;
  return is_new ? sync_folder(m_folder, faults) : Status();
}

Status Manifest::add(const ManifestEntry& entry, const FaultHook& faults) {
  if (!is_one_word(entry.name) || !is_one_word(entry.key) || !is_one_word(entry.sha256))
    return make_error(ErrorCode::bad_input, "{}: cannot record '{}' with key '{}': names and keys are one plain word",
                      path().string(), entry.name, entry.key);
  Status appended = append(fmt::format("have {} {} {} {}", entry.name, entry.size, entry.sha256, entry.key), faults);
  if (appended) {
    forget(entry.name);
    m_entries.push_back(entry);
  }
  return appended;
}

Status Manifest::remove(std::string_view name, const FaultHook& faults) {
  if (find(name) == nullptr)
    return {};
  Status appended = append(fmt::format("gone {}", name), faults);
  if (appended)
    forget(name);
  return appended;
}

} // namespace wry::pipeline
