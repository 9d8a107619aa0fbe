#include "sim/base/parallel.h"

#include <algorithm>
#include <thread>
#include <vector>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/partitioner.h>
#include <oneapi/tbb/task_arena.h>

namespace wry {

struct Threads::Arena {
  explicit Arena(int count)
      : thread_count(count)
      , arena(std::min(count, most_workers())) {}

  /// More threads than processors would only fight for them; results do not depend on how many there are.
  static int most_workers() {
    return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
  }

  int thread_count;
  tbb::task_arena arena;
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
  if (m_arena->thread_count == 1 || chunks == 1) {
    for (std::size_t chunk = 0; chunk < chunks; ++chunk)
      run_chunk(chunk);
    return;
  }
  m_arena->arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, chunks, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          for (std::size_t chunk = range.begin(); chunk < range.end(); ++chunk)
            run_chunk(chunk);
        },
        tbb::simple_partitioner());
  });
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
