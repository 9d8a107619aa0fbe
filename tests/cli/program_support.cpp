#include "tests/cli/program_support.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "pipeline/cache/frame_cache.h"

namespace wry::cli_test {

namespace fs = std::filesystem;

namespace {

pid_t start(const std::vector<std::string>& arguments, const fs::path& folder, const fs::path& out,
            const fs::path& err) {
  std::vector<char*> words = {const_cast<char*>(WRY_PROGRAM)};
  for (const std::string& argument : arguments)
    words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  const pid_t child = fork();
  if (child != 0)
    return child;
  const int out_file = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  const int err_file = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (out_file < 0 || err_file < 0 || dup2(out_file, 1) < 0 || dup2(err_file, 2) < 0 || chdir(folder.c_str()) != 0)
    _exit(126);
  execv(words[0], words.data());
  _exit(127);
}

Outcome finish(pid_t child, const fs::path& out, const fs::path& err) {
  int status = 0;
  waitpid(child, &status, 0);
  Outcome outcome;
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.out = read_text(out);
  outcome.err = read_text(err);
  return outcome;
}

} // namespace

Outcome run_wry(const std::vector<std::string>& arguments, const fs::path& folder) {
  const TemporaryFolder logs;
  const pid_t child = start(arguments, folder, logs.path() / "out", logs.path() / "err");
  return finish(child, logs.path() / "out", logs.path() / "err");
}

Outcome run_wry_and_signal(const std::vector<std::string>& arguments, const fs::path& folder, int signal,
                           int milliseconds) {
  const TemporaryFolder logs;
  const pid_t child = start(arguments, folder, logs.path() / "out", logs.path() / "err");
  std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
  kill(child, signal);
  return finish(child, logs.path() / "out", logs.path() / "err");
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (fs::temp_directory_path() / "wry-test-XXXXXX").string();
  m_path = mkdtemp(pattern.data());
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(m_path, ignored);
}

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

std::string read_text(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

std::vector<std::string> frame_hashes(const fs::path& out) {
  std::vector<std::string> hashes;
  const Result<pipeline::FrameCache> cache = pipeline::FrameCache::open_to_read(out / "frames");
  if (!cache)
    return hashes;
  for (const pipeline::CachedFrame& frame : cache->frames())
    hashes.push_back(std::to_string(frame.number) + " " + frame.sha256);
  return hashes;
}

std::string small_shot() {
  return R"([shot]
name = "bar"
frames = "1-9"
fps = 24

[[body]]
name = "bar"
box = { size = [0.4, 0.1, 0.1] }
translate = [0, 0.12, 0]
resolution = 0.05
material = "soft"

[material.soft]
model = "micropolar"
youngs_modulus = 2e4
poisson_ratio = 0.3
length_scale = 0.02
curvature = { model = "isotropic", alpha = 1, beta = 1, gamma = 1 }

[[fixed]]
name = "end"
body = "bar"
where = { box = { min = [-0.21, 0, -1], max = [-0.19, 1, 1] } }

[[collider]]
name = "floor"
plane = { height = 0, normal = "y" }
friction = 0.3

[render]
size = [160, 90]
samples = 1

[[measure]]
name = "height"
kind = "height"
)";
}

} // namespace wry::cli_test
