#include "pipeline/assets/import_process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace wry::pipeline {

namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* CHILD_MARK = "WRY_IMPORT_CHILD";
constexpr int OUT_OF_MEMORY_EXIT = static_cast<int>(ErrorCode::out_of_memory);

class Descriptor {
public:
  explicit Descriptor(int fd)
      : m_fd(fd) {}
  ~Descriptor() { reset(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return m_fd; }
  void reset() {
    if (m_fd >= 0)
      close(m_fd);
    m_fd = -1;
  }

private:
  int m_fd;
};

// A child that is killed and reaped at the latest when this goes out of scope.
class Child {
public:
  explicit Child(pid_t pid)
      : m_pid(pid) {}
  ~Child() {
    if (m_reaped)
      return;
    kill(m_pid, SIGKILL);
    wait(0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  // Whether it has ended; its wait status is then known.
  bool wait(int options) {
    pid_t result = 0;
    do
      result = waitpid(m_pid, &m_status, options);
    while (result < 0 && errno == EINTR);
    m_reaped = m_reaped || result != 0;
    return m_reaped;
  }
  int status() const { return m_status; }

private:
  pid_t m_pid;
  int m_status = 0;
  bool m_reaped = false;
};

// The child sees as little of our environment as it needs to start.
std::vector<std::string> child_environment() {
  std::vector<std::string> environment = {"LC_ALL=C", std::string(CHILD_MARK) + "=1"};
  for (const char* name : {"LD_LIBRARY_PATH", "ASAN_OPTIONS", "UBSAN_OPTIONS", "LSAN_OPTIONS", "LLVM_PROFILE_FILE"})
    if (const char* value = std::getenv(name))
      environment.push_back(std::string(name) + "=" + value);
  return environment;
}

std::vector<char*> pointers(std::vector<std::string>& strings) {
  std::vector<char*> result;
  result.reserve(strings.size() + 1);
  for (std::string& text : strings)
    result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

Result<pid_t> start(const ImportProcess& process, int answer_fd) {
  const std::string program = process.program.empty() ? "/proc/self/exe" : process.program;
  std::vector<std::string> arguments = {"wry",
                                        IMPORT_VERB,
                                        process.path,
                                        process.node,
                                        std::to_string(process.limits.memory_bytes),
                                        std::to_string(process.limits.cpu_seconds),
                                        process.what == ImportWhat::motion ? "motion" : "mesh"};
  std::vector<std::string> environment = child_environment();
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_adddup2(&actions, answer_fd, IMPORT_ANSWER_FD);
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&actions, fd, "/dev/null", fd == STDIN_FILENO ? O_RDONLY : O_WRONLY, 0);
  sigset_t none;
  sigset_t all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  pid_t pid = 0;
  const int failure = posix_spawn(&pid, program.c_str(), &actions, &attributes, pointers(arguments).data(),
                                  pointers(environment).data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0)
    return make_error(ErrorCode::io, "cannot start the import process {}: {}", program, std::strerror(failure));
  return pid;
}

int milliseconds_until(Clock::time_point deadline) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
  return static_cast<int>(std::max<std::int64_t>(0, left));
}

// Reads until the writer closes, the deadline passes or there is too much; false for the latter two.
enum class ReadEnd { closed, too_late, too_much };

ReadEnd read_all(int fd, Clock::time_point deadline, std::uint64_t limit, std::string& bytes) {
  std::array<char, 1 << 16> buffer{};
  while (true) {
    pollfd waiting{fd, POLLIN, 0};
    const int ready = poll(&waiting, 1, milliseconds_until(deadline));
    if (ready < 0 && errno == EINTR)
      continue;
    if (ready <= 0)
      return ReadEnd::too_late;
    const ssize_t count = read(fd, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR)
      continue;
    if (count <= 0)
      return ReadEnd::closed;
    if (bytes.size() + static_cast<std::size_t>(count) > limit)
      return ReadEnd::too_much;
    bytes.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

Error too_late(const ImportProcess& process) {
  return make_error(
      ErrorCode::bad_input,
      "{}: reading took longer than {} s and was stopped: the file is damaged, or too large for one import",
      process.path, process.limits.wall_seconds);
}

Error killed(const ImportProcess& process, int signal) {
  if (signal == SIGXCPU)
    return make_error(
        ErrorCode::bad_input,
        "{}: reading took more than {} s of processor time and was stopped (SIGXCPU): the file is damaged, or too "
        "large for one import",
        process.path, process.limits.cpu_seconds);
  const char* name = sigabbrev_np(signal);
  return make_error(
      ErrorCode::bad_input,
      "{}: the reader crashed on this file (SIG{}), in a process of its own: the file is damaged, or uses what the "
      "reader cannot do; export it again, as OBJ, PLY or GLB",
      process.path, name ? name : std::to_string(signal));
}

Error out_of_memory(const ImportProcess& process) {
  return make_error(ErrorCode::bad_input,
                    "{}: reading needs more than {} MiB of memory: the file is damaged, or too large", process.path,
                    process.limits.memory_bytes >> 20);
}

} // namespace

Result<std::string> run_import_process(const ImportProcess& process) {
  if (std::getenv(CHILD_MARK) != nullptr)
    return make_error(ErrorCode::io, "an import process tried to import: its main does not call import_child_main");
  int ends[2] = {-1, -1};
  if (pipe2(ends, O_CLOEXEC) != 0)
    return make_error(ErrorCode::io, "cannot make a pipe for importing: {}", std::strerror(errno));
  const Descriptor reading(ends[0]);
  Descriptor writing(ends[1]);
  const Result<pid_t> pid = start(process, writing.get());
  if (!pid)
    return pid.error();
  writing.reset();
  Child child(*pid);
  const Clock::time_point deadline = Clock::now() + std::chrono::seconds(process.limits.wall_seconds);
  std::string bytes;
  const ReadEnd end = read_all(reading.get(), deadline, process.limits.memory_bytes, bytes);
  if (end == ReadEnd::too_late)
    return too_late(process);
  if (end == ReadEnd::too_much)
    return out_of_memory(process);
  while (!child.wait(WNOHANG)) {
    if (milliseconds_until(deadline) == 0)
      return too_late(process);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (WIFSIGNALED(child.status()))
    return killed(process, WTERMSIG(child.status()));
  if (WEXITSTATUS(child.status()) == OUT_OF_MEMORY_EXIT)
    return out_of_memory(process);
  if (WEXITSTATUS(child.status()) != 0)
    return make_error(ErrorCode::io, "{}: the import process ended with code {}", process.path,
                      WEXITSTATUS(child.status()));
  return bytes;
}

} // namespace wry::pipeline
