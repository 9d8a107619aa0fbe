#pragma once

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace wry::test {

/// All entries of "vectors" in the .json files of tests/data/vectors and of the folder in WRY_TEST_VECTORS, in the
/// order of their paths.
inline std::vector<nlohmann::json> all_vectors() {
  std::vector<std::filesystem::path> folders = {std::filesystem::path(WRY_TEST_DATA) / "vectors"};
  if (const char* more = std::getenv("WRY_TEST_VECTORS"); more != nullptr && *more != '\0')
    folders.emplace_back(more);
  std::vector<std::filesystem::path> files;
  for (const auto& folder : folders) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() == ".json")
        files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<nlohmann::json> vectors;
  for (const auto& file : files) {
    const nlohmann::json content = nlohmann::json::parse(std::ifstream(file));
    if (!content.is_object() || !content.contains("vectors") || !content.at("vectors").is_array())
      continue;
    for (const auto& vector : content.at("vectors"))
      vectors.push_back(vector);
  }
  return vectors;
}

} // namespace wry::test
