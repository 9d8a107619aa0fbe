#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/assets/mesh_import.h"
#include "sim/geometry/primitives.h"
#include "tests/pipeline/import_files_support.h"

namespace wry::pipeline {
namespace {

namespace fs = std::filesystem;

// What became of many files.
struct Tally {
  int imported = 0;
  int refused = 0;
  double slowest = 0; // [s]

  // Imports the file and holds the answer to the promise: a mesh that can be used, or a clean error, in time.
  void hold(const std::string& path) {
    const auto begin = std::chrono::steady_clock::now();
    const Result<ImportedMesh> mesh = import_mesh(path);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    slowest = std::max(slowest, seconds);
    EXPECT_LT(seconds, 10 + 5) << path; // processor time is limited to 10 s; the machine may be busy
    if (!mesh) {
      ++refused;
      EXPECT_TRUE(mesh.error().code == ErrorCode::bad_input || mesh.error().code == ErrorCode::missing_input ||
                  mesh.error().code == ErrorCode::unavailable)
          << path << ": " << mesh.error().message;
      EXPECT_GT(mesh.error().message.size(), path.size()) << path;
      return;
    }
    ++imported;
    EXPECT_TRUE(mesh->report.is_valid()) << path;
    EXPECT_TRUE(mesh->mesh.vertices.allFinite()) << path;
    for (const geometry::VertexAttribute& attribute : mesh->mesh.attributes)
      EXPECT_EQ(attribute.values.size(),
                static_cast<std::size_t>(attribute.components) * static_cast<std::size_t>(mesh->mesh.vertices.rows()))
          << path;
  }

  void say(const std::string& what) const {
    std::cout << what << ": " << imported << " imported, " << refused << " refused, slowest " << slowest << " s\n";
  }
};

std::string mutated(std::string bytes, std::mt19937& random) {
  const int edits = 1 + static_cast<int>(random() % 4);
  for (int i = 0; i < edits && !bytes.empty(); ++i) {
    const std::size_t at = random() % bytes.size();
    switch (random() % 6) {
    case 0:
      bytes[at] = static_cast<char>(random() % 256);
      break;
    case 1:
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
      break;
    case 2:
      bytes.erase(at, random() % 64);
      break;
    case 3:
      bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 64));
      break;
    case 4:
      bytes.insert(at, "-99999999999");
      break;
    default:
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), std::min<std::size_t>(8, bytes.size() - at), '\xff');
    }
  }
  return bytes;
}

class EveryDamagedKind : public testing::TestWithParam<const char*> {};

TEST_P(EveryDamagedKind, EndsInAMeshOrACleanError) {
  const std::string kind = GetParam();
  const TemporaryFolder folder;
  const std::string whole = mesh_file_bytes(geometry::make_torus(1.0, 0.3, geometry::Axis::y, 0.4).value(), kind);
  std::mt19937 random(2026);
  Tally mutations;
  for (int i = 0; i < 120; ++i)
    mutations.hold(folder.write("damaged" + extension_of(kind), mutated(whole, random)));
  mutations.say(kind + ", 120 mutations");
  // Files hurt in the first bytes meet the most code.
  Tally heads;
  for (int i = 0; i < 40; ++i) {
    std::string bytes = whole;
    bytes[random() % std::min<std::size_t>(bytes.size(), 200)] = static_cast<char>(random() % 256);
    heads.hold(folder.write("head" + extension_of(kind), bytes));
  }
  heads.say(kind + ", 40 damaged heads");
  Tally truncations;
  for (int i = 0; i < 40; ++i)
    truncations.hold(folder.write("cut" + extension_of(kind), whole.substr(0, random() % whole.size())));
  truncations.say(kind + ", 40 truncations");
  EXPECT_GT(mutations.refused + heads.refused + truncations.refused, 20);
}

INSTANTIATE_TEST_SUITE_P(Import, EveryDamagedKind,
                         testing::Values("obj", "stl", "stl-ascii", "off", "glb", "ply-ascii", "ply-little", "ply-big"),
                         [](const auto& parameter) {
                           std::string name = parameter.param;
                           name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
                           return name;
                         });

// WRY_TEST_MESHES names a folder; without it, Debian's assimp-testmodels are taken where they are installed.
TEST(ImportFolder, EveryFileEndsInAMeshOrACleanError) {
  const char* named = std::getenv("WRY_TEST_MESHES");
  const fs::path folder = named != nullptr ? named : "/usr/share/assimp/models";
  if (!fs::is_directory(folder))
    GTEST_SKIP() << "no folder of meshes here: set WRY_TEST_MESHES, or install assimp-testmodels";
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  Tally tally;
  for (const fs::path& file : files)
    tally.hold(file.string());
  tally.say(folder.string());
  EXPECT_EQ(tally.imported + tally.refused, static_cast<int>(files.size()));
}

} // namespace
} // namespace wry::pipeline
