#include "pipeline/assets/import_child.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <string>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "pipeline/assets/file_checks.h"
#include "pipeline/assets/import_process.h"
#include "pipeline/assets/ply_reader.h"
#include "pipeline/assets/sandbox.h"
#include "pipeline/assets/scene_decoder.h"

namespace wry::pipeline {

namespace {

constexpr std::size_t MAX_COMPANIONS = 64;

Result<std::string> read_file(const std::string& path) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (fd < 0)
    return make_error(errno == ENOENT || errno == ENOTDIR ? ErrorCode::missing_input : ErrorCode::io,
                      "cannot open {}: {}", path, std::strerror(errno));
  struct stat info {};
  if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
    close(fd);
    return make_error(ErrorCode::bad_input, "{} is not a file", path);
  }
  std::string bytes(static_cast<std::size_t>(info.st_size), '\0');
  std::size_t at = 0;
  while (at < bytes.size()) {
    const ssize_t count = read(fd, bytes.data() + at, bytes.size() - at);
    if (count < 0 && errno == EINTR)
      continue;
    if (count <= 0)
      break;
    at += static_cast<std::size_t>(count);
  }
  close(fd);
  if (at != bytes.size())
    return make_error(ErrorCode::io, "cannot read all of {}: {} of {} bytes", path, at, bytes.size());
  return bytes;
}

std::string lower_extension(const std::string& path) {
  const std::size_t dot = path.find_last_of("./");
  if (dot == std::string::npos || path[dot] != '.')
    return {};
  std::string extension = path.substr(dot + 1);
  for (char& c : extension)
    c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension;
}

// Buffers that a glTF file names, from its own folder only: "uri" : "name.bin".
std::vector<std::string> companion_names(const std::string& gltf) {
  std::vector<std::string> names;
  for (std::size_t at = gltf.find("\"uri\""); at != std::string::npos && names.size() < MAX_COMPANIONS;
       at = gltf.find("\"uri\"", at + 1)) {
    const std::size_t begin = gltf.find('"', at + 5);
    const std::size_t end = begin == std::string::npos ? begin : gltf.find('"', begin + 1);
    if (end == std::string::npos || end - begin > 256)
      continue;
    const std::string name = gltf.substr(begin + 1, end - begin - 1);
    if (name.size() > 4 && name.substr(name.size() - 4) == ".bin" && name.find('/') == std::string::npos)
      names.push_back(name);
  }
  return names;
}

/// Names of pictures and material libraries that a file mentions anywhere: letters before .png, .jpg, .jpeg, .tga or
/// .mtl, without their folders.
std::vector<std::string> mentioned_names(const std::string& bytes) {
  std::vector<std::string> names;
  for (std::size_t dot = bytes.find('.'); dot != std::string::npos && names.size() < MAX_COMPANIONS;
       dot = bytes.find('.', dot + 1)) {
    const std::string ending = lower_extension(bytes.substr(dot, 5));
    const std::size_t length = ending.starts_with("jpeg") ? 5
                               : ending.starts_with("png") || ending.starts_with("jpg") || ending.starts_with("tga") ||
                                       ending.starts_with("mtl")
                                   ? 4
                                   : 0;
    if (length == 0)
      continue;
    std::size_t begin = dot;
    while (begin > 0 && dot - begin < 128 && bytes[begin - 1] > ' ' &&
           std::strchr("/\\\"'<>=|*?:", bytes[begin - 1]) == nullptr)
      --begin;
    const std::string name = bytes.substr(begin, dot + length - begin);
    if (begin < dot && std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
  }
  return names;
}

/// Reads what a file mentions from its own folder; what is not there is told when a material wants it.
void load_mentioned(const std::string& folder, const std::string& bytes, MeshFile& file) {
  for (const std::string& name : mentioned_names(bytes)) {
    if (file.files.size() >= MAX_COMPANIONS || file.files.count(name) != 0)
      continue;
    Result<std::string> companion = read_file(folder + name);
    if (!companion)
      continue;
    const bool library = lower_extension(name) == "mtl";
    if (library)
      load_mentioned(folder, *companion, file);
    file.files[name] = std::move(*companion);
  }
}

Result<MeshFile> load(const std::string& path, const std::string& node, ImportWhat what) {
  MeshFile file;
  const std::size_t slash = path.find_last_of('/');
  const std::string folder = slash == std::string::npos ? "" : path.substr(0, slash + 1);
  file.extension = lower_extension(path);
  file.name = "mesh." + file.extension;
  file.node = node;
  file.what = what;
  Result<std::string> bytes = read_file(path);
  if (!bytes)
    return std::move(bytes).error();
  if (file.extension == "gltf") {
    for (const std::string& name : companion_names(*bytes)) {
      Result<std::string> companion = read_file(folder + name);
      if (!companion)
        return make_error(companion.error().code, "it needs its buffer: {}", companion.error().message);
      file.files[name] = std::move(*companion);
    }
  }
  if (file.extension != "ply" && file.extension != "stl" && file.extension != "off")
    load_mentioned(folder, *bytes, file);
  file.files[file.name] = std::move(*bytes);
  return file;
}

Result<RawMesh> decode(MeshFile& file) {
  std::string& bytes = file.files.at(file.name);
  if (file.extension == "ply" && file.what == ImportWhat::motion)
    return make_error(ErrorCode::bad_input, "a PLY file has no animation");
  if (file.extension == "ply") {
    if (!file.node.empty())
      return make_error(ErrorCode::bad_input, "a PLY file has no nodes, so none can be called '{}'", file.node);
    return read_ply(bytes);
  }
  std::vector<std::string> notes;
  if (Status status = check_file(bytes, file.extension, notes); !status)
    return status.error();
  if (file.extension == "obj")
    bytes = without_trailing_comments(std::move(bytes));
  Result<RawMesh> raw = decode_scene(file);
  if (raw)
    raw->notes.insert(raw->notes.end(), notes.begin(), notes.end());
  return raw;
}

Result<RawMesh> import_locked_in(const std::string& path, const std::string& node, ImportWhat what,
                                 const SandboxLimits& limits) {
  if (Status status = limit_resources(limits); !status)
    return status.error();
  Result<MeshFile> file = load(path, node, what);
  if (!file)
    return file.error();
  const Status forbidden = forbid_system_calls();
  Result<RawMesh> raw = decode(*file);
  if (raw && !forbidden)
    raw->notes.push_back("read under limits of memory and time only: " + forbidden.error().message);
  return raw;
}

bool write_all(const std::string& bytes) {
  std::size_t at = 0;
  while (at < bytes.size()) {
    const ssize_t count = write(IMPORT_ANSWER_FD, bytes.data() + at, bytes.size() - at);
    if (count < 0 && errno == EINTR)
      continue;
    if (count <= 0)
      return false;
    at += static_cast<std::size_t>(count);
  }
  return true;
}

void end_for_want_of_memory() {
  _exit(static_cast<int>(ErrorCode::out_of_memory));
}

/// Matrices throw bad_alloc from malloc, which asks no handler of new.
void end_uncaught() {
  try {
    if (const std::exception_ptr thrown = std::current_exception())
      std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    end_for_want_of_memory();
  } catch (...) {
  }
  std::abort();
}

} // namespace

bool is_import_child(int argc, char** argv) {
  return argc >= 2 && std::strcmp(argv[1], IMPORT_VERB) == 0;
}

int import_child_main(int argc, char** argv) {
  if (argc != 7 || !is_import_child(argc, argv))
    return static_cast<int>(ErrorCode::usage);
  std::set_new_handler(end_for_want_of_memory);
  std::set_terminate(end_uncaught);
  syscall(SYS_close_range, IMPORT_ANSWER_FD + 1, ~0U, 0);
  SandboxLimits limits;
  limits.memory_bytes = std::strtoull(argv[4], nullptr, 10);
  limits.cpu_seconds = static_cast<int>(std::strtol(argv[5], nullptr, 10));
  const Result<RawMesh> raw = import_locked_in(
      argv[2], argv[3], std::strcmp(argv[6], "motion") == 0 ? ImportWhat::motion : ImportWhat::mesh, limits);
  // No destructors and no handlers at exit: they would run over what a damaged file may have left behind.
  _exit(write_all(encode_answer(raw)) ? 0 : static_cast<int>(ErrorCode::io));
}

} // namespace wry::pipeline
