#include "tests/layering/include_rules.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>

namespace wry::layering {

namespace fs = std::filesystem;

namespace {

using Rooms = std::set<std::string>;

const Rooms BASE = {"sim/base"};
const Rooms GEOMETRY = {"sim/base", "sim/geometry"};
const Rooms STATE = {"sim/base", "sim/geometry", "sim/state"};
const Rooms SCENE = {"sim/base", "sim/geometry", "sim/state", "sim/scene"};
const Rooms CONTACT = {"sim/base", "sim/geometry", "sim/state", "sim/scene", "sim/contact"};
const Rooms ALL_OF_SIM = {"sim/base",    "sim/geometry", "sim/state", "sim/scene",
                          "sim/contact", "sim/fem",      "sim/mpm",   "sim"};

Rooms operator+(Rooms rooms, const Rooms& more) {
  rooms.insert(more.begin(), more.end());
  return rooms;
}

const Rooms PIPELINE_SEES = ALL_OF_SIM + Rooms{"shots", "render"};

/// What each room may include besides itself. This is the drawing of the house; a new room or part needs a line here.
const std::map<std::string, Rooms> ARROWS = {
    {"sim/base", {}},
    {"sim/geometry", BASE},
    {"sim/state", GEOMETRY},
    {"sim/scene", STATE},
    {"sim/contact", SCENE},
    {"sim/fem", CONTACT},
    {"sim/mpm", SCENE},
    {"sim", ALL_OF_SIM},
    {"shots", BASE},
    {"shots/meshes/make", GEOMETRY}, // programs beside the shots, not part of them
    {"render", STATE},
    {"pipeline/cache", STATE},
    {"pipeline/report", PIPELINE_SEES + Rooms{"pipeline/cache"}},
    {"pipeline/measure", PIPELINE_SEES + Rooms{"pipeline/cache"}},
    {"pipeline/assets", PIPELINE_SEES + Rooms{"pipeline/cache"}},
    {"pipeline/plan",
     PIPELINE_SEES + Rooms{"pipeline/cache", "pipeline/assets", "pipeline/measure", "pipeline/report"}},
    {"pipeline/run", PIPELINE_SEES + Rooms{"pipeline/cache", "pipeline/assets", "pipeline/measure", "pipeline/plan",
                                           "pipeline/report"}},
    {"pipeline/export", PIPELINE_SEES + Rooms{"pipeline/cache", "pipeline/assets", "pipeline/report"}},
    {"pipeline/study", PIPELINE_SEES + Rooms{"pipeline/cache", "pipeline/assets", "pipeline/measure", "pipeline/plan",
                                             "pipeline/report", "pipeline/run"}},
    {"pipeline/cli", PIPELINE_SEES + Rooms{"pipeline/cache", "pipeline/assets", "pipeline/measure", "pipeline/plan",
                                           "pipeline/report", "pipeline/run", "pipeline/export", "pipeline/study"}},
    {"pipeline", {"pipeline/cli"}},
};

/// Headers of others that stay in .cpp files, by how their names begin.
const std::vector<std::string> KEPT_OUT_OF_HEADERS = {
    "openvdb/", "assimp/",  "hdf5",     "H5",    "cholmod", "suitesparse/", "GL/",       "EGL/",      "toml",
    "CLI/",     "muParser", "openssl/", "png.h", "OpenEXR", "Imf",          "nlohmann/", "libdeflate"};

/// A folder whose headers may name GL: the wall behind which it stays. Only render may include them.
const std::string GL_WALL = "render/gl/";

/// What a kernel file must not see, directly or through our headers: inline functions of these, compiled for a wide
/// machine, could be the copy that the linker keeps for all.
const std::vector<std::string> KEPT_OUT_OF_KERNELS = {"Eigen/", "vector",     "string", "algorithm", "functional",
                                                      "memory", "fmt/",       "map",    "iostream",  "sstream",
                                                      "tbb/",   "filesystem", "numeric"};

struct Include {
  std::string name;
  bool is_ours = false; ///< in quotes
  int line = 0;
};

struct Source {
  std::string path; ///< relative to the root, with slashes
  std::string room;
  std::vector<Include> includes;
  std::string first_code_line;
};

bool begins_with_any(const std::string& name, const std::vector<std::string>& beginnings) {
  return std::any_of(beginnings.begin(), beginnings.end(), [&](const std::string& b) {
    return b.back() == '/' || b == "H5" || b == "Imf"
               ? name.starts_with(b)
               : name == b || name.starts_with(b + ".") || name.starts_with(b + "/") || name.starts_with(b + "+");
  });
}

/// The longest room of ARROWS that the path lies in; for an unknown part of pipeline or sim, that part.
std::string room_of(const std::string& path) {
  if (path.starts_with("shots/meshes/make/"))
    return "shots/meshes/make";
  const fs::path folder = fs::path(path).parent_path();
  auto part = folder.begin();
  if (part == folder.end())
    return {};
  const std::string top = part->string();
  if (top != "sim" && top != "pipeline")
    return top;
  return ++part == folder.end() ? top : top + "/" + part->string();
}

Source read_source(const fs::path& root, const std::string& path) {
  static const std::regex INCLUDE(R"(^\s*#\s*include\s*(["<])([^">]+)[">].*)");
  Source source{path, room_of(path), {}, {}};
  std::ifstream file(root / path);
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    std::smatch match;
    if (source.first_code_line.empty() && !line.empty() && !line.starts_with("//"))
      source.first_code_line = line;
    if (std::regex_match(line, match, INCLUDE))
      source.includes.push_back({match[2], match[1] == "\"", number});
  }
  return source;
}

std::vector<std::string> source_paths(const fs::path& root) {
  std::vector<std::string> paths;
  for (const char* top : {"sim", "shots", "render", "pipeline", "tests"}) {
    if (!fs::is_directory(root / top))
      continue;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / top)) {
      const std::string extension = entry.path().extension().string();
      if (entry.is_regular_file() && (extension == ".h" || extension == ".cpp"))
        paths.push_back(fs::relative(entry.path(), root).generic_string());
    }
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

/// The name that a kernel sees and should not, with the way to it; empty when there is none.
std::string forbidden_in_kernel(const std::map<std::string, Source>& sources, const std::string& path,
                                std::set<std::string>& seen) {
  const auto found = sources.find(path);
  if (found == sources.end() || !seen.insert(path).second)
    return {};
  for (const Include& include : found->second.includes) {
    if (!include.is_ours && begins_with_any(include.name, KEPT_OUT_OF_KERNELS))
      return "<" + include.name + "> through " + path;
    if (!include.is_ours)
      continue;
    if (const std::string inner = forbidden_in_kernel(sources, include.name, seen); !inner.empty())
      return inner;
  }
  return {};
}

class Checker {
public:
  explicit Checker(const fs::path& root)
      : m_root(root) {
    for (const std::string& path : source_paths(root))
      m_sources.emplace(path, read_source(root, path));
  }

  std::vector<Violation> check() {
    for (const auto& [path, source] : m_sources) {
      check_arrows(source);
      if (path.ends_with(".h"))
        check_header(source);
      if (path.ends_with(".kernel.cpp"))
        check_kernel(source);
    }
    return std::move(m_violations);
  }

private:
  void add(const Source& source, int line, std::string what) {
    m_violations.push_back({source.path, line, std::move(what)});
  }

  void check_arrows(const Source& source) {
    const bool is_test = source.room == "tests";
    const auto arrows = ARROWS.find(source.room);
    if (!is_test && arrows == ARROWS.end()) {
      add(source, 0, source.room + " is no room that the layering knows: give it a line in ARROWS");
      return;
    }
    for (const Include& include : source.includes) {
      if (!include.is_ours)
        continue;
      if (!fs::exists(m_root / include.name)) {
        add(source, include.line, include.name + " is no file from the top of the project");
        continue;
      }
      const std::string other = room_of(include.name);
      if (!is_test && other != source.room && !arrows->second.contains(other))
        add(source, include.line, source.room + " may not include " + include.name);
      if (include.name.starts_with(GL_WALL) && source.room != "render" && !is_test)
        add(source, include.line, include.name + " stays within render");
    }
  }

  void check_header(const Source& source) {
    if (source.first_code_line != "#pragma once")
      add(source, 0, "a header starts with #pragma once");
    for (const Include& include : source.includes) {
      const bool is_behind_wall = source.path.starts_with(GL_WALL) && include.name.starts_with("GL/");
      if (source.room != "tests" && !is_behind_wall && begins_with_any(include.name, KEPT_OUT_OF_HEADERS))
        add(source, include.line, include.name + " stays out of our headers: include it in a .cpp");
    }
  }

  void check_kernel(const Source& source) {
    std::set<std::string> seen;
    if (const std::string way = forbidden_in_kernel(m_sources, source.path, seen); !way.empty())
      add(source, 0, "a kernel sees " + way);
  }

  fs::path m_root;
  std::map<std::string, Source> m_sources;
  std::vector<Violation> m_violations;
};

} // namespace

std::vector<Violation> check_includes(const fs::path& root) {
  return Checker(root).check();
}

std::size_t count_sources(const fs::path& root) {
  return source_paths(root).size();
}

} // namespace wry::layering
