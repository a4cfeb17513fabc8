#include "mpi/connections.hpp"

#include <utility>

#include "support/catch.hpp"

using namespace ringsplat;
using namespace std::chrono_literals;

namespace {

/// Sleeps in so many seconds of waiting, from when there was work last.
int sleeps_within(std::chrono::nanoseconds time, std::chrono::nanoseconds longest) {
  int sleeps = 0;
  for (long waits = 1; time > 0ns; ++waits) {
    const Pause pause = pause_after(waits, 64, longest);
    sleeps += pause.sleeps > 0ns;
    time -= pause.sleeps;
  }
  return sleeps;
}

}  // namespace

TEST_CASE("A rank that waits spins, then yields, then sleeps ever longer") {
  CHECK(pause_after(1, 64, longest_amid_frame) == Pause{});
  CHECK(pause_after(32, 64, longest_amid_frame) == Pause{});
  CHECK(pause_after(33, 64, longest_amid_frame) == Pause{.yields = true});
  CHECK(pause_after(96, 64, longest_amid_frame) == Pause{.yields = true});
  CHECK(pause_after(97, 64, longest_amid_frame) == Pause{.sleeps = 20us});
  CHECK(pause_after(100'000, 64, longest_amid_frame).sleeps == longest_amid_frame);
  for (long waits = 97; waits < 5000; ++waits)
    CHECK(pause_after(waits, 64, 2ms).sleeps <= pause_after(waits + 1, 64, 2ms).sleeps);
}

TEST_CASE("Between frames ranks soon wake a few hundred times a second, amid one thousands of times") {
  const auto longest = longest_between_frames(4);
  CHECK(sleeps_within(12s, longest) - sleeps_within(2s, longest) <= 10 * 500 + 1);
  CHECK(sleeps_within(2s, longest_amid_frame) >= 10'000);
}

TEST_CASE("An announcement reaches the last rank soon, however many there are") {
  for (const auto& [ranks, depth] : {std::pair{1, 0}, {2, 1}, {3, 2}, {4, 2}, {5, 3}, {16, 4}, {1000, 10}}) {
    const auto longest = longest_between_frames(ranks);
    CHECK(longest <= 4ms);
    CHECK(depth * longest <= 4ms);
  }
  CHECK(longest_between_frames(1 << 24) == longest_amid_frame);
}
