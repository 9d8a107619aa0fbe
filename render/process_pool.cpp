#include "render/process_pool.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace wry::render {
namespace {

/// What a child tells its parent after an index. Small enough for one write to be atomic.
struct Report {
  int index = 0;
  int code = 0; ///< 0: done
  std::array<char, 2000> message{};
};
static_assert(sizeof(Report) <= PIPE_BUF);

/// The next index, in memory that all the processes share.
class SharedCounter {
public:
  SharedCounter()
      : m_memory(::mmap(nullptr, sizeof(std::atomic<int>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
    if (m_memory != MAP_FAILED)
      m_next = new (m_memory) std::atomic<int>(0);
  }
  ~SharedCounter() {
    if (m_memory != MAP_FAILED)
      ::munmap(m_memory, sizeof(std::atomic<int>));
  }
  SharedCounter(const SharedCounter&) = delete;
  SharedCounter& operator=(const SharedCounter&) = delete;

  bool made() const { return m_next != nullptr; }
  int take() { return m_next->fetch_add(1); }
  void end(int count) { m_next->store(count); }

private:
  void* m_memory;
  std::atomic<int>* m_next = nullptr;
};

void tell(int pipe_end, int index, const Status& status) {
  Report report;
  report.index = index;
  if (!status.ok()) {
    report.code = static_cast<int>(status.error().code);
    status.error().message.copy(report.message.data(), report.message.size() - 1);
  }
  while (::write(pipe_end, &report, sizeof(report)) < 0 && errno == EINTR) {
  }
}

/// The whole life of a child.
void run_child(const PooledWork& work, SharedCounter& counter, int pipe_end) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  const Result<std::function<Status(int)>> one = work.prepare();
  for (int index = counter.take(); index < work.count; index = counter.take()) {
    const Status status = one.ok() ? (*one)(index) : Status(one.error());
    tell(pipe_end, index, status);
    if (!status.ok()) {
      counter.end(work.count);
      return;
    }
  }
}

/// Reads reports until every child has closed its end. Keeps the failure of the lowest index.
std::optional<Report> listen(const PooledWork& work, SharedCounter& counter, int pipe_end, bool& stopped) {
  std::optional<Report> failure;
  while (true) {
    if (!stopped && work.should_stop && work.should_stop()) {
      stopped = true;
      counter.end(work.count);
    }
    pollfd waiting{pipe_end, POLLIN, 0};
    if (::poll(&waiting, 1, 200) <= 0)
      continue;
    Report report;
    const ssize_t got = ::read(pipe_end, &report, sizeof(report));
    if (got == 0)
      return failure;
    if (got != static_cast<ssize_t>(sizeof(report)))
      continue;
    if (report.code == 0 && work.done)
      work.done(report.index);
    if (report.code != 0 && (!failure.has_value() || report.index < failure->index))
      failure = report;
  }
}

Status wait_for(const std::vector<pid_t>& children) {
  Status status;
  for (const pid_t child : children) {
    int ended = 0;
    while (::waitpid(child, &ended, 0) < 0 && errno == EINTR) {
    }
    if (!WIFSIGNALED(ended))
      continue;
    const int signal = WTERMSIG(ended);
    if (signal == SIGTERM || signal == SIGINT)
      status = make_error(ErrorCode::stopped, "a drawing process was stopped by signal {}", signal);
    else
      status = make_error(signal == SIGKILL ? ErrorCode::out_of_memory : ErrorCode::io,
                          "a drawing process was ended by signal {} ({}); with signal 9 there was likely too little "
                          "memory: use fewer processes",
                          signal, ::strsignal(signal));
  }
  return status;
}

} // namespace

Status run_in_processes(const PooledWork& work) {
  SharedCounter counter;
  std::array<int, 2> ends{};
  if (!counter.made() || ::pipe(ends.data()) != 0)
    return make_error(ErrorCode::out_of_memory, "cannot share memory between processes: {}", std::strerror(errno));
  std::vector<pid_t> children;
  Status status;
  for (int i = 0; i < std::clamp(work.processes, 1, std::clamp(work.count, 1, 256)); ++i) {
    const pid_t child = ::fork();
    if (child == 0) {
      ::close(ends[0]);
      run_child(work, counter, ends[1]);
      ::_exit(0);
    }
    if (child < 0) {
      counter.end(work.count);
      status = make_error(ErrorCode::out_of_memory, "cannot start drawing process {}: {}", i + 1, std::strerror(errno));
      break;
    }
    children.push_back(child);
  }
  ::close(ends[1]);
  bool stopped = false;
  const std::optional<Report> failure = listen(work, counter, ends[0], stopped);
  ::close(ends[0]);
  const Status ended = wait_for(children);
  if (!status.ok())
    return status;
  if (failure.has_value())
    return Error{static_cast<ErrorCode>(failure->code), std::string(failure->message.data())};
  if (!ended.ok())
    return ended;
  if (stopped)
    return make_error(ErrorCode::stopped, "drawing was stopped; the pictures that are done are kept");
  return {};
}

} // namespace wry::render
