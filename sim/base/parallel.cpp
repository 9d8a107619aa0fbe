#include "sim/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace wry {

namespace {

/// Between two loops a thread looks out for the next one for so long before it sleeps: waking it takes about as long,
/// and iterations of a linear solver follow each other faster.
constexpr std::chrono::microseconds LOOK_OUT{100};
/// Looks between two looks at the clock.
constexpr int LOOKS = 32;

void pause_briefly() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#else
  std::this_thread::yield();
#endif
}

/// Whether `done()` became true within LOOK_OUT.
template <class Done> bool look_out_for(const Done& done) {
  const auto start = std::chrono::steady_clock::now();
  do {
    for (int look = 0; look < LOOKS; ++look) {
      if (done())
        return true;
      pause_briefly();
    }
  } while (std::chrono::steady_clock::now() - start < LOOK_OUT);
  return done();
}

using RunChunk = std::function<void(std::size_t)>;

} // namespace

/// The caller and its helpers. Each loop has a number; each thread has a share of its chunks, always the same ones for
/// loops of the same size, so that what it touches stays in its cache, and takes from the others' when it is through.
/// The caller waits for chunks that somebody has begun, never for a helper that has not come yet.
struct Threads::Arena {
  explicit Arena(int count)
      : thread_count(count)
      , m_shares(static_cast<std::size_t>(std::min(count, processors()))) {}

  ~Arena() {
    {
      const std::lock_guard<std::mutex> lock(m_mutex);
      m_stopping = true;
    }
    m_wake_up.notify_all();
    for (std::thread& helper : m_helpers)
      helper.join();
  }

  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  /// More threads than processors would only fight for them; results do not depend on how many there are.
  static int processors() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

  /// False when there is nobody to share with, or the threads are at work already: then the caller works alone.
  bool run(std::size_t chunks, const RunChunk& run_chunk) {
    if (m_shares.size() == 1 || chunks == 1 || m_busy.exchange(true, std::memory_order_acquire))
      return false;
    while (m_helpers.size() + 1 < m_shares.size())
      m_helpers.emplace_back([this, mine = m_helpers.size() + 1] { help(mine); });
    const std::uint32_t loop = m_current.load(std::memory_order_relaxed) + 1;
    m_job = &run_chunk;
    m_failed.store(false, std::memory_order_relaxed);
    m_unfinished.store(chunks, std::memory_order_relaxed);
    for (std::size_t i = 0; i < m_shares.size(); ++i) {
      m_shares[i].end = chunks * (i + 1) / m_shares.size();
      const std::uint64_t left = m_shares[i].end - chunks * i / m_shares.size();
      m_shares[i].left.store(std::uint64_t(loop) << 32 | left, std::memory_order_release);
    }
    m_current.store(loop);
    if (m_sleepers.load() > 0) {
      { const std::lock_guard<std::mutex> lock(m_mutex); }
      m_wake_up.notify_all();
    }
    work(0, loop);
    wait_for_others();
    const std::exception_ptr thrown = std::exchange(m_failure, nullptr);
    m_busy.store(false, std::memory_order_release);
    if (thrown)
      std::rethrow_exception(thrown);
    return true;
  }

  int thread_count;

private:
  struct alignas(64) Share {
    std::atomic<std::uint64_t> left = 0; ///< number of the loop, and below it how many chunks nobody has begun
    std::size_t end = 0;                 ///< one past the last chunk; may be read by who has taken a chunk
  };

  static bool take(Share& share, std::uint32_t loop, std::size_t& chunk) {
    std::uint64_t seen = share.left.load(std::memory_order_acquire);
    while (static_cast<std::uint32_t>(seen >> 32) == loop && static_cast<std::uint32_t>(seen) != 0) {
      if (share.left.compare_exchange_weak(seen, seen - 1, std::memory_order_acq_rel, std::memory_order_acquire)) {
        chunk = share.end - static_cast<std::uint32_t>(seen);
        return true;
      }
    }
    return false;
  }

  /// Chunks of the own share, then of the others', until none is left. A loop that is over has none.
  void work(std::size_t mine, std::uint32_t loop) {
    std::size_t done = 0;
    for (std::size_t i = 0; i < m_shares.size(); ++i) {
      std::size_t chunk = 0;
      for (Share& share = m_shares[(mine + i) % m_shares.size()]; take(share, loop, chunk); ++done)
        run_one(chunk);
    }
    if (done == 0 || m_unfinished.fetch_sub(done) != done)
      return;
    if (mine != 0 && m_caller_sleeps.load()) {
      { const std::lock_guard<std::mutex> lock(m_mutex); }
      m_all_done.notify_one();
    }
  }

  void run_one(std::size_t chunk) {
    if (m_failed.load(std::memory_order_relaxed))
      return;
    try {
      (*m_job)(chunk);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(m_mutex);
      if (!m_failed.exchange(true))
        m_failure = std::current_exception();
    }
  }

  void wait_for_others() {
    const auto done = [this] { return m_unfinished.load(std::memory_order_acquire) == 0; };
    if (look_out_for(done))
      return;
    std::unique_lock<std::mutex> lock(m_mutex);
    m_caller_sleeps.store(true);
    m_all_done.wait(lock, [this] { return m_unfinished.load() == 0; });
    m_caller_sleeps.store(false);
  }

  void help(std::size_t mine) {
    for (std::uint32_t seen = 0;;) {
      const auto called = [this, &seen] { return m_current.load() != seen; };
      if (!look_out_for(called)) {
        std::unique_lock<std::mutex> lock(m_mutex);
        ++m_sleepers;
        m_wake_up.wait(lock, [&] { return m_stopping || called(); });
        --m_sleepers;
        if (m_stopping)
          return;
      }
      seen = m_current.load();
      work(mine, seen);
    }
  }

  std::vector<Share> m_shares; ///< the caller's first
  std::vector<std::thread> m_helpers;
  std::atomic<bool> m_busy = false;
  const RunChunk* m_job = nullptr;
  std::atomic<bool> m_failed = false;
  std::exception_ptr m_failure;
  alignas(64) std::atomic<std::uint32_t> m_current = 0; ///< number of the last loop
  alignas(64) std::atomic<std::size_t> m_unfinished = 0;
  std::atomic<bool> m_caller_sleeps = false;
  std::atomic<int> m_sleepers = 0;
  bool m_stopping = false;
  std::mutex m_mutex;
  std::condition_variable m_wake_up, m_all_done;
};

Threads::Threads(int count)
    : m_arena(std::make_unique<Arena>(count > 0 ? count
                                                : std::max(1, static_cast<int>(std::thread::hardware_concurrency())))) {
}

Threads::~Threads() = default;

int Threads::count() const {
  return m_arena->thread_count;
}

void Threads::for_chunks(std::size_t size, std::size_t grain,
                         const std::function<void(std::size_t, std::size_t)>& body) const {
  if (size == 0)
    return;
  grain = std::max<std::size_t>(1, grain);
  const std::size_t chunks = (size + grain - 1) / grain;
  const auto run_chunk = [&](std::size_t chunk) { body(chunk * grain, std::min(size, (chunk + 1) * grain)); };
  if (m_arena->run(chunks, run_chunk))
    return;
  for (std::size_t chunk = 0; chunk < chunks; ++chunk)
    run_chunk(chunk);
}

double Threads::sum_chunks(std::size_t size, std::size_t grain,
                           const std::function<double(std::size_t, std::size_t)>& body) const {
  grain = std::max<std::size_t>(1, grain);
  const std::size_t chunks = (size + grain - 1) / grain;
  std::vector<double> partial(chunks, 0.0);
  for_chunks(size, grain, [&](std::size_t begin, std::size_t end) { partial[begin / grain] = body(begin, end); });
  double sum = 0.0;
  for (const double value : partial)
    sum += value;
  return sum;
}

} // namespace wry
