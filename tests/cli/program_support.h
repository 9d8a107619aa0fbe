#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace wry::cli_test {

/// What a run of the program left behind.
struct Outcome {
  int exit_code = 0; ///< 128 + signal when it was killed
  std::string out;
  std::string err;
};

/// Runs the program with arguments in a folder and waits.
Outcome run_wry(const std::vector<std::string>& arguments, const std::filesystem::path& folder);

/// Runs it, sends a signal after so many milliseconds, and waits.
Outcome run_wry_and_signal(const std::vector<std::string>& arguments, const std::filesystem::path& folder, int signal,
                           int milliseconds);

/// An empty folder that goes away with the object.
class TemporaryFolder {
public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return m_path; }

private:
  std::filesystem::path m_path;
};

void write_text(const std::filesystem::path& path, const std::string& text);
std::string read_text(const std::filesystem::path& path);

/// Names and hashes of the finished frames of an output folder, in the order of their names.
std::vector<std::string> frame_hashes(const std::filesystem::path& out);

/// A small shot that has everything: a micropolar bar, held at one end, that falls onto a floor.
std::string small_shot();

} // namespace wry::cli_test
