#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace wry {

/// A fixed number of threads that run loops whose results do not depend on that number.
///
/// Work is cut into chunks by `grain` alone, never by the number of threads; a reduction adds the chunks' results in
/// order. So every result is the same, bit for bit, on any number of threads. Threads sleep when there is no work.
/// Exceptions of the body reach the caller.
class Threads {
public:
  /// `count` threads including the caller's; 0 means as many as the machine has.
  explicit Threads(int count = 0);
  ~Threads();
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

  int count() const;

  /// Calls body(begin, end) for consecutive chunks of at most `grain` indices that cover [0, size).
  void for_chunks(std::size_t size, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) const;

  /// Calls body(i) for every i in [0, size), in chunks of `grain`.
  template <class Body> void for_each(std::size_t size, std::size_t grain, const Body& body) const {
    for_chunks(size, grain, [&body](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        body(i);
    });
  }

  /// Sum of body(begin, end) over the chunks, added in the order of the chunks.
  double sum_chunks(std::size_t size, std::size_t grain,
                    const std::function<double(std::size_t, std::size_t)>& body) const;

private:
  struct Arena;
  std::unique_ptr<Arena> m_arena;
};

} // namespace wry
