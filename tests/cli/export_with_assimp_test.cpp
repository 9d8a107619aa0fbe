#include <filesystem>

#include <assimp/Importer.hpp>
#include <assimp/scene.h>
#include <gtest/gtest.h>

#include "pipeline/cache/frame_cache.h"
#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

namespace fs = std::filesystem;

/// Reads an exported mesh with assimp, which we did not write, and compares it with the cache.
void expect_same(const fs::path& file, const std::vector<double>& positions, std::size_t triangles) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(file.string(), 0);
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  ASSERT_EQ(scene->mNumMeshes, 1u);
  const aiMesh& mesh = *scene->mMeshes[0];
  EXPECT_EQ(mesh.mNumFaces, triangles);
  // Readers may give every corner a vertex of its own: each must be one of ours, and the bounds agree.
  double low = 1e9, high = -1e9, ours_low = 1e9, ours_high = -1e9;
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    low = std::min<double>(low, mesh.mVertices[i].x);
    high = std::max<double>(high, mesh.mVertices[i].x);
  }
  for (std::size_t i = 0; i < positions.size(); i += 3) {
    ours_low = std::min(ours_low, positions[i]);
    ours_high = std::max(ours_high, positions[i]);
  }
  EXPECT_FLOAT_EQ(static_cast<float>(low), static_cast<float>(ours_low));
  EXPECT_FLOAT_EQ(static_cast<float>(high), static_cast<float>(ours_high));
}

TEST(ExportReadByAssimp, PlyAndObjComeBack) {
  const TemporaryFolder folder;
  write_text(folder.path() / "bar.toml", small_shot());
  ASSERT_EQ(run_wry({"simulate", "bar.toml", "--out", "o", "--frames", "1-2"}, folder.path()).exit_code, 0);
  const Outcome outcome =
      run_wry({"export", "bar.toml", "--out", "o", "--frames", "1-2", "--to", "ply,obj"}, folder.path());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Result<pipeline::FrameCache> cache = pipeline::FrameCache::open_to_read(folder.path() / "o" / "frames");
  const auto triangles = static_cast<std::size_t>(cache->read_static()->bodies.at(0).triangles.rows());
  for (int frame = 1; frame <= 2; ++frame) {
    const Result<Frame> cached = cache->read_frame(frame);
    const std::vector<double> positions = find_channel(cached->bodies.at(0), "position")->values;
    for (const std::string format : {"ply", "obj"})
      expect_same(folder.path() / "o" / "exports" / format / ("bar.000" + std::to_string(frame) + "." + format),
                  positions, triangles);
  }
}

} // namespace
} // namespace wry::cli_test
