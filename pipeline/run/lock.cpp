#include "pipeline/run/lock.h"

#include <array>
#include <cerrno>
#include <condition_variable>
#include <fcntl.h>
#include <mutex>
#include <optional>
#include <sstream>
#include <sys/file.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cache/file_error.h"

namespace wry::pipeline {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view TITLE = "wry-lock-1";
constexpr std::string_view NOTHING = "-";                     ///< for an empty word
constexpr int MOST_ATTEMPTS = 1000;                           ///< at opening a lock file that others keep removing
constexpr auto WRITING_TIME = std::chrono::milliseconds(500); ///< a new holder has written its name by then

std::string one_word(const fs::path& path) {
  const Result<std::string> text = read_whole_file(path);
  // Files of /proc have no size, so read_whole_file() may see nothing.
  if (text && !text->empty())
    return text->substr(0, text->find('\n'));
  std::array<char, 128> buffer{};
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const ssize_t count = file < 0 ? 0 : ::read(file, buffer.data(), buffer.size());
  if (file >= 0)
    ::close(file);
  const std::string word(buffer.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
  return word.substr(0, word.find('\n'));
}

/// Field 22 of /proc/PID/stat, after the name in brackets that may hold anything; 0 for no such process.
unsigned long long start_of_process(long pid) {
  std::array<char, 1024> buffer{};
  const int file = ::open(fmt::format("/proc/{}/stat", pid).c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0)
    return 0;
  const ssize_t count = ::read(file, buffer.data(), buffer.size());
  ::close(file);
  const std::string text(buffer.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
  const std::size_t bracket = text.rfind(')');
  if (bracket == std::string::npos)
    return 0;
  std::istringstream fields(text.substr(bracket + 1));
  std::string field;
  for (int number = 3; number <= 22 && fields >> field; ++number) {
    if (number == 3 && (field == "Z" || field == "X"))
      return 0;
  }
  return std::strtoull(field.c_str(), nullptr, 10);
}

/// Same length for every count, so that one write replaces another whole.
std::string record_of(const LockHolder& holder, unsigned long long count) {
  return fmt::format("{} host {} machine {} boot {} namespace {} pid {} start {} count {:020}\n", TITLE, holder.host,
                     holder.machine, holder.boot, holder.pid_namespace, holder.pid, holder.start, count);
}

struct Record {
  LockHolder holder;
  unsigned long long count = 0;
};

std::optional<Record> parse_record(const std::string& text) {
  Record record;
  std::istringstream words(text);
  std::string title, name;
  LockHolder& holder = record.holder;
  words >> title >> name >> holder.host >> name >> holder.machine >> name >> holder.boot >> name >>
      holder.pid_namespace;
  words >> name >> holder.pid >> name >> holder.start >> name >> record.count;
  if (!words || title != TITLE || text.back() != '\n')
    return std::nullopt;
  return record;
}

enum class Verdict { alive, dead, unknown };

/// Of a holder whose flock() is not held any more, as far as this machine sees.
Verdict judge(const LockHolder& holder) {
  const LockHolder here = this_process();
  if (holder.boot == here.boot && here.boot != NOTHING) {
    const bool is_visible = holder.pid_namespace == here.pid_namespace;
    return is_visible && start_of_process(holder.pid) == holder.start ? Verdict::alive : Verdict::dead;
  }
  const bool is_this_machine = holder.host == here.host && holder.machine == here.machine && here.machine != NOTHING;
  return is_this_machine ? Verdict::dead : Verdict::unknown;
}

std::string describe(const LockHolder& holder) {
  return fmt::format("process {} on {}", holder.pid, holder.host);
}

Error held_error(const fs::path& path, const std::optional<Record>& record) {
  const std::string who = record ? describe(record->holder) : "another process";
  const std::string elsewhere = record && record->holder.boot != this_process().boot
                                    ? fmt::format("; if that machine is gone for good, remove {}", path.string())
                                    : std::string();
  return make_error(
      ErrorCode::cannot_write,
      "{} is in use by another run: {} holds its lock; wait for it, stop it, or choose another folder with "
      "--out{}",
      path.parent_path().string(), who, elsewhere);
}

/// The record at `path`, waiting a little for one that is just being written.
std::optional<Record> read_record(const fs::path& path) {
  const auto deadline = std::chrono::steady_clock::now() + WRITING_TIME;
  for (;;) {
    const Result<std::string> text = read_whole_file(path);
    const std::optional<Record> record = text && !text->empty() ? parse_record(*text) : std::nullopt;
    if (record || std::chrono::steady_clock::now() > deadline)
      return record;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

/// Whether the count in the lock file stands still for `patience`. The file is opened anew each time: that is when a
/// network file system looks at the server.
bool count_stands_still(const fs::path& path, unsigned long long count, std::chrono::milliseconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(patience / 20);
    const Result<std::string> text = read_whole_file(path);
    const std::optional<Record> record = text && !text->empty() ? parse_record(*text) : std::nullopt;
    if (record && record->count != count)
      return false;
  }
  return true;
}

bool is_still_named(int file, const fs::path& path) {
  struct stat mine {};
  struct stat named {};
  return ::fstat(file, &mine) == 0 && ::stat(path.c_str(), &named) == 0 && mine.st_ino == named.st_ino &&
         mine.st_dev == named.st_dev;
}

Status write_record(int file, const fs::path& path, const std::string& text) {
  if (::pwrite(file, text.data(), text.size(), 0) != static_cast<ssize_t>(text.size()) ||
      ::ftruncate(file, static_cast<off_t>(text.size())) < 0)
    return write_error("write", path, errno);
  return {};
}

} // namespace

LockHolder this_process() {
  LockHolder here;
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) == 0)
    here.host = host.data();
  std::array<char, 64> name{};
  if (const ssize_t count = ::readlink("/proc/self/ns/pid", name.data(), name.size()); count > 0)
    here.pid_namespace.assign(name.data(), static_cast<std::size_t>(count));
  here.machine = one_word("/etc/machine-id");
  here.boot = one_word("/proc/sys/kernel/random/boot_id");
  for (std::string* word : {&here.host, &here.machine, &here.boot, &here.pid_namespace}) {
    if (word->empty())
      *word = std::string(NOTHING);
  }
  here.pid = ::getpid();
  here.start = start_of_process(here.pid);
  return here;
}

/// The open lock file and the thread that counts up in it.
struct FolderLock::Held {
  Held(fs::path file_path, int descriptor)
      : path(std::move(file_path))
      , file(descriptor)
      , holder(this_process()) {}

  ~Held() {
    {
      const std::lock_guard lock(mutex);
      done = true;
    }
    wake.notify_all();
    if (beater.joinable())
      beater.join();
    // A forked child shares the lock but does not own it.
    if (owned && holder.pid == ::getpid() && is_still_named(file, path))
      ::unlink(path.c_str());
    ::close(file);
  }

  void beat(std::chrono::milliseconds pause) {
    std::unique_lock lock(mutex);
    for (unsigned long long count = 1; !wake.wait_for(lock, pause, [this] { return done; }); ++count) {
      const std::string text = record_of(holder, count);
      // A full disk may refuse this; the lock itself does not depend on it.
      [[maybe_unused]] const ssize_t written = ::pwrite(file, text.data(), text.size(), 0);
    }
  }

  Status take_over(const Settings& settings);

  fs::path path;
  int file;
  LockHolder holder;
  std::string recovered;
  bool owned = false;
  bool done = false;
  std::mutex mutex;
  std::condition_variable wake;
  std::thread beater;
};

FolderLock::FolderLock(std::unique_ptr<Held> held)
    : m_held(std::move(held)) {}
FolderLock::~FolderLock() = default;
FolderLock::FolderLock(FolderLock&&) noexcept = default;
FolderLock& FolderLock::operator=(FolderLock&&) noexcept = default;

const std::string& FolderLock::recovered_from() const {
  return m_held->recovered;
}

/// With the kernel's lock in hand: looks at what a former holder left, then writes its own name.
Status FolderLock::Held::take_over(const Settings& settings) {
  const Result<std::string> left = read_whole_file(path);
  if (left && !left->empty()) {
    const std::optional<Record> record = parse_record(*left);
    const Verdict verdict = record ? judge(record->holder) : Verdict::dead;
    if (verdict == Verdict::alive)
      return held_error(path, record);
    if (verdict == Verdict::unknown && !count_stands_still(path, record->count, settings.patience))
      return held_error(path, record);
    recovered = fmt::format("took over the stale lock of {} on {}",
                            record ? describe(record->holder) : "a run that was killed", path.parent_path().string());
  }
  if (Status written = write_record(file, path, record_of(holder, 0)); !written)
    return written;
  owned = true;
  beater = std::thread([this, pause = settings.beat] { beat(pause); });
  return {};
}

Result<FolderLock> FolderLock::acquire(const fs::path& folder, const Settings& settings) {
  const fs::path path = folder / "lock";
  for (int attempt = 0; attempt < MOST_ATTEMPTS; ++attempt) {
    const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file < 0)
      return write_error("lock", path, errno);
    auto held = std::make_unique<Held>(path, file);
    if (::flock(file, LOCK_EX | LOCK_NB) < 0) {
      if (errno == EINTR)
        continue;
      if (errno == EWOULDBLOCK)
        return held_error(path, read_record(path));
      return make_error(
          ErrorCode::cannot_write,
          "cannot lock {}: {}; choose a folder with --out on a disk that supports flock (on Lustre: mount "
          "it with -o flock)",
          path.string(), std::generic_category().message(errno));
    }
    // A former holder may have removed the file between open and flock: then this lock is of a file without a name.
    if (!is_still_named(file, path))
      continue;
    if (Status taken = held->take_over(settings); !taken)
      return taken.error();
    return FolderLock(std::move(held));
  }
  return make_error(ErrorCode::cannot_write, "cannot lock {}: other runs keep taking and leaving it", path.string());
}

} // namespace wry::pipeline
