#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace ringsplat::truth {

/// Calls body(first, end) for pieces of [0, count) on all cores; passes the first exception to the caller.
/// The calling thread calls `poll` before each of its pieces.
template <class Body>
void parallel_for(std::size_t count, std::size_t piece, const Body& body,
                  const std::function<void()>& poll = {}) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_lock;
  const auto work = [&](bool polls) {
    try {
      for (std::size_t first = next.fetch_add(piece); first < count; first = next.fetch_add(piece)) {
        if (polls && poll) poll();
        body(first, std::min(first + piece, count));
      }
    } catch (...) {
      const std::lock_guard hold(failure_lock);
      if (!failure) failure = std::current_exception();
      next = count;
    }
  };
  const std::size_t pieces = (count + piece - 1) / piece;
  const std::size_t threads =
      std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, std::max<std::size_t>(pieces, 1));
  std::vector<std::thread> others;
  for (std::size_t t = 1; t < threads; ++t) others.emplace_back(work, false);
  work(true);
  for (auto& other : others) other.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace ringsplat::truth
