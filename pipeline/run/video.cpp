#include "pipeline/run/video.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cache/file_error.h"
#include "pipeline/run/signals.h"

extern char** environ;

namespace wry::pipeline {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

std::vector<std::string> arguments(const fs::path& aside, const VideoSettings& settings) {
  // Pictures are sRGB; scale's matrix and the tags say the same, so that players show the same colours.
  const std::string filter = "crop=trunc(iw/2)*2:trunc(ih/2)*2,scale=in_range=full:out_range=tv:out_color_matrix=bt709:"
                             "flags=accurate_rnd+full_chroma_int,format=yuv420p";
  const std::string fps = fmt::format("{}", settings.fps);
  return {settings.program, "-hide_banner", "-loglevel", "error", "-nostats", "-f", "image2pipe", "-c:v", "png",
          "-framerate", fps, "-i", "pipe:0", "-an", "-vf", filter, "-c:v", "libx264", "-preset", "medium", "-crf",
          fmt::format("{}", settings.crf), "-threads", fmt::format("{}", settings.threads), "-colorspace", "bt709",
          "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv", "-map_metadata", "-1", "-fflags",
          "+bitexact", "-flags:v", "+bitexact", "-movflags", "+faststart", "-f", "mp4", "-y",
          // A name that starts with a dash, or looks like a protocol, stays a file.
          "file:" + fs::absolute(aside).string()};
}

/// A running encoder: pictures go into `input`, its words come to `words`.
class Encoder {
public:
  ~Encoder() {
    if (m_input >= 0)
      ::close(m_input);
    if (m_words >= 0)
      ::close(m_words);
    if (m_process > 0) {
      ::kill(m_process, SIGKILL);
      ::waitpid(m_process, nullptr, 0);
    }
  }

  Status start(const std::vector<std::string>& command);
  /// Errors: io when the program takes nothing for `patience`, or has ended.
  Status feed(std::string_view bytes, std::chrono::seconds patience);
  /// Waits for its end. Errors: io.
  Status finish(std::chrono::seconds patience);

private:
  Error failed(std::string_view how) const;
  std::string last_words() const;

  pid_t m_process = -1;
  int m_input = -1;
  int m_words = -1;
  std::string m_program;
};

Error no_program(const std::string& program, int error_number) {
  return make_error(ErrorCode::unavailable,
                    "cannot start {}: {}; install it (apt-get install ffmpeg) for films; the pictures are there",
                    program, std::generic_category().message(error_number));
}

Status Encoder::start(const std::vector<std::string>& command) {
  m_program = command[0];
  int ends[2] = {-1, -1};
  // A socket instead of a pipe: sending into one whose reader is gone can be an error instead of a signal.
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) < 0)
    return make_error(ErrorCode::io, "cannot speak to {}: {}", m_program, std::generic_category().message(errno));
  m_input = ends[0];
  m_words = ::memfd_create("words", MFD_CLOEXEC);
  std::vector<char*> argv;
  for (const std::string& argument : command)
    argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawnattr_init(&attributes);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
  ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  if (m_words >= 0)
    ::posix_spawn_file_actions_adddup2(&actions, m_words, STDERR_FILENO);
  // Ctrl-C reaches the whole group of a terminal: the encoder is ours to stop, so it gets a group of its own.
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const int failure = ::posix_spawnp(&m_process, argv[0], &actions, &attributes, argv.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::posix_spawnattr_destroy(&attributes);
  ::close(ends[1]);
  if (failure == 0)
    return {};
  m_process = -1;
  return no_program(m_program, failure);
}

std::string Encoder::last_words() const {
  constexpr off_t MOST = 600;
  const off_t size = std::max<off_t>(::lseek(m_words, 0, SEEK_END), 0);
  std::string words(static_cast<std::size_t>(std::min(size, MOST)), '\0');
  const ssize_t count = ::pread(m_words, words.data(), words.size(), size - static_cast<off_t>(words.size()));
  words.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  while (!words.empty() && words.back() == '\n')
    words.pop_back();
  return words.empty() ? "it said nothing" : words;
}

Error Encoder::failed(std::string_view how) const {
  return make_error(ErrorCode::io, "{} {}: {}", m_program, how, last_words());
}

Status Encoder::feed(std::string_view bytes, std::chrono::seconds patience) {
  while (!bytes.empty()) {
    pollfd ready{m_input, POLLOUT, 0};
    const int count = ::poll(&ready, 1, static_cast<int>(std::chrono::milliseconds(patience).count()));
    if (stop_requested())
      return stopped_by_signal("the film was left out, the pictures are there");
    if (count < 0 && errno == EINTR)
      continue;
    if (count == 0)
      return failed(fmt::format("took no picture for {} s", patience.count()));
    const ssize_t sent = ::send(m_input, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && (errno == EINTR || errno == EAGAIN))
      continue;
    if (sent < 0)
      return failed("ended early");
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return {};
}

Status Encoder::finish(std::chrono::seconds patience) {
  ::close(std::exchange(m_input, -1));
  const Clock::time_point deadline = Clock::now() + patience;
  int outcome = 0;
  for (;;) {
    const pid_t ended = ::waitpid(m_process, &outcome, WNOHANG);
    if (ended == m_process)
      break;
    if (stop_requested())
      return stopped_by_signal("the film was left out, the pictures are there");
    if (Clock::now() > deadline)
      return failed(fmt::format("did not end within {} s", patience.count()));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  m_process = -1;
  if (WIFEXITED(outcome) && WEXITSTATUS(outcome) == 0)
    return {};
  return WIFSIGNALED(outcome) ? failed(fmt::format("was killed by signal {}", WTERMSIG(outcome)))
                              : failed(fmt::format("failed with {}", WEXITSTATUS(outcome)));
}

Status encode(const std::vector<fs::path>& pictures, const fs::path& aside, const VideoSettings& settings) {
  Encoder encoder;
  if (Status started = encoder.start(arguments(aside, settings)); !started)
    return started;
  for (const fs::path& picture : pictures) {
    const Result<std::string> bytes = read_whole_file(picture);
    if (!bytes)
      return bytes.error();
    if (Status fed = encoder.feed(*bytes, settings.patience); !fed)
      return fed;
  }
  return encoder.finish(settings.patience);
}

Status sync_file(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = file >= 0 && ::fsync(file) == 0;
  const int failure = errno;
  if (file >= 0)
    ::close(file);
  return synced ? Status() : Status(write_error("write", path, failure));
}

} // namespace

bool has_video_program(const std::string& program) {
  if (program.find('/') != std::string::npos)
    return ::access(program.c_str(), X_OK) == 0;
  const char* folders = std::getenv("PATH");
  std::string_view rest = folders == nullptr ? "" : folders;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    if (::access((fs::path(rest.substr(0, end)) / program).c_str(), X_OK) == 0)
      return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

Status encode_video(const std::vector<fs::path>& pictures, const fs::path& film, const VideoSettings& settings) {
  if (pictures.empty())
    return make_error(ErrorCode::missing_input, "{}: there is no picture to make a film of", film.string());
  const fs::path aside = aside_of(film);
  Status made = encode(pictures, aside, settings);
  if (made)
    made = sync_file(aside);
  if (!made) {
    static_cast<void>(remove_file(aside));
    return Error{made.error().code, fmt::format("{}: {}", film.string(), made.error().message)};
  }
  return publish(aside, film);
}

} // namespace wry::pipeline
