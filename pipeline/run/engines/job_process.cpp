#include "pipeline/run/engines/job_process.h"

#include <algorithm>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <thread>

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/run/signals.h"

extern char** environ;

namespace wry::pipeline {

namespace {

constexpr const char* PARENT_VARIABLE = "WRY_PARENT";
constexpr std::streamoff TAIL_BYTES = 4096;
/// A job's time is that of its processor; waiting for one, which other work may cause, counts half.
constexpr double WAITING_COUNTS_LESS = 2.0;
constexpr double SECONDS_TO_STOP = 10.0; ///< after SIGTERM, before SIGKILL
constexpr std::size_t LONGEST_REASON = 400;

std::string tail_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file)
    return {};
  const std::streamoff size = file.tellg();
  file.seekg(std::max<std::streamoff>(0, size - TAIL_BYTES));
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string host_name() {
  char name[256] = "";
  return gethostname(name, sizeof name - 1) == 0 ? name : "-";
}

/// posix_spawn attributes and actions, released with the object.
struct SpawnPlan {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  SpawnPlan() {
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
  }
  ~SpawnPlan() {
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
  }
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;
};

/// CPU time that a running process has taken, all its threads; where it cannot be had, `otherwise` [s].
double cpu_seconds_of(pid_t process, double otherwise) {
  clockid_t clock = 0;
  timespec time{};
  if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &time) != 0)
    return otherwise;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> list;
  list.reserve(words.size() + 1);
  for (std::string& word : words)
    list.push_back(word.data());
  list.push_back(nullptr);
  return list;
}

} // namespace

JobProcess::JobProcess(const Job& job, pid_t child)
    : m_job(&job)
    , m_child(child)
    , m_start(std::chrono::steady_clock::now()) {}

Result<JobProcess> JobProcess::start(const Job& job) {
  if (Status status = prepare_folder(job.log.parent_path()); !status)
    return status.error();
  SpawnPlan plan;
  posix_spawn_file_actions_addopen(&plan.actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&plan.actions, STDOUT_FILENO, job.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&plan.actions, STDOUT_FILENO, STDERR_FILENO);
  posix_spawnattr_setflags(&plan.attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&plan.attributes, 0);
  std::vector<std::string> words = {"wry"};
  words.insert(words.end(), job.arguments.begin(), job.arguments.end());
  announce_parent();
  pid_t child = 0;
  const int failed =
      posix_spawn(&child, this_program().c_str(), &plan.actions, &plan.attributes, pointers(words).data(), environ);
  if (failed != 0)
    return make_error(ErrorCode::unavailable, "{}: cannot start a process: {}", job.id, std::strerror(failed));
  return JobProcess(job, child);
}

Result<std::optional<JobRecord>> JobProcess::poll() {
  int status = 0;
  rusage used{};
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
  if (wait4(m_child, &status, WNOHANG, &used) == 0) {
    const double limit = m_job->time_limit_seconds;
    const bool late = cpu_seconds_of(m_child, elapsed) > limit || elapsed > WAITING_COUNTS_LESS * limit;
    if (limit > 0.0 && late && !m_timed_out) {
      m_timed_out = true;
      m_asked_at = elapsed;
      ask_to_stop();
    } else if (m_timed_out && elapsed > m_asked_at + SECONDS_TO_STOP && !m_killed) {
      m_killed = true;
      kill(-m_child, SIGKILL);
    }
    return std::optional<JobRecord>();
  }
  JobRecord record;
  record.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  record.timed_out = m_timed_out;
  record.wall_seconds = elapsed;
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  record.cpu_seconds = seconds(used.ru_utime) + seconds(used.ru_stime);
  record.peak_bytes = static_cast<std::uint64_t>(used.ru_maxrss) * 1024;
  record.host = host_name();
  record.key = m_job->key;
  if (record.timed_out)
    record.reason = fmt::format("took longer than {:g} s", m_job->time_limit_seconds);
  else if (record.exit_code > 128)
    record.reason = fmt::format("killed by signal {}: {}", record.exit_code - 128, last_words(m_job->log));
  else if (record.exit_code != 0)
    record.reason = last_words(m_job->log);
  if (Status written = write_job_record(*m_job, record); !written)
    return written.error();
  return std::optional<JobRecord>(std::move(record));
}

void JobProcess::ask_to_stop() {
  kill(m_child, SIGTERM); // it passes it on to its own children
}

int JobProcess::percent() const {
  const std::string tail = tail_of(m_job->log);
  const std::size_t at = tail.rfind("progress ");
  return at == std::string::npos ? -1 : std::atoi(tail.c_str() + at + 9);
}

Result<JobRecord> run_job(const Job& job) {
  Result<JobProcess> process = JobProcess::start(job);
  if (!process)
    return process.error();
  bool passed_on = false;
  while (true) {
    Result<std::optional<JobRecord>> ended = process->poll();
    if (!ended)
      return ended.error();
    if (*ended)
      return std::move(**ended);
    if (stop_requested() && !passed_on) {
      process->ask_to_stop();
      passed_on = true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

std::string last_words(const std::filesystem::path& log) {
  const std::string tail = tail_of(log);
  // From the last line that names the program's verb on, which is how every error of ours begins.
  std::size_t at = tail.rfind("\nwry ");
  at = at == std::string::npos ? (tail.starts_with("wry ") ? 0 : std::string::npos) : at + 1;
  if (at == std::string::npos) {
    const std::size_t end = tail.find_last_not_of('\n');
    at = end == std::string::npos || tail.rfind('\n', end) == std::string::npos ? 0 : tail.rfind('\n', end) + 1;
  }
  std::string words = tail.substr(at);
  while (!words.empty() && words.back() == '\n')
    words.pop_back();
  if (words.size() > LONGEST_REASON)
    words = words.substr(0, LONGEST_REASON) + " ...";
  return words;
}

std::string this_program() {
  char path[PATH_MAX] = "";
  const ssize_t length = readlink("/proc/self/exe", path, sizeof path - 1);
  return length > 0 ? std::string(path, static_cast<std::size_t>(length)) : "wry";
}

void announce_parent() {
  setenv(PARENT_VARIABLE, std::to_string(getpid()).c_str(), 1);
}

void follow_parent() {
  const char* parent = std::getenv(PARENT_VARIABLE);
  if (parent == nullptr)
    return;
  const long expected = std::atol(parent);
  unsetenv(PARENT_VARIABLE);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != expected)
    raise(SIGTERM); // it died before this one was set up
}

} // namespace wry::pipeline
