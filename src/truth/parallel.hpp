#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <future>
#include <thread>
#include <vector>

namespace ringsplat::truth {

/// Told now and then which share of a truth's pixels is done; may throw to end its evaluation.
using Poll = std::function<void(double done)>;

/// Calls body(first, end) for pieces of [0, count) on all cores; passes an exception to the caller. The
/// calling thread calls `poll` before each of its pieces.
template <class Body>
void parallel_for(std::size_t count, std::size_t piece, const Body& body, const Poll& poll = {}) {
  std::atomic<std::size_t> next{0};
  const auto work = [&](bool polls) {
    try {
      for (std::size_t first = next.fetch_add(piece); first < count; first = next.fetch_add(piece)) {
        if (polls && poll) poll(double(first) / double(count));
        body(first, std::min(first + piece, count));
      }
    } catch (...) {
      next = count;
      throw;
    }
  };
  const std::size_t pieces = (count + piece - 1) / piece;
  const std::size_t threads =
      std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, std::max<std::size_t>(pieces, 1));
  std::vector<std::future<void>> others;  // which the destructor waits for
  for (std::size_t t = 1; t < threads; ++t) others.push_back(std::async(std::launch::async, work, false));
  work(true);
  for (auto& other : others) other.get();
}

}  // namespace ringsplat::truth
