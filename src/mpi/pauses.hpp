#pragma once
#include <chrono>

namespace ringsplat {

/// What a rank does that has nothing to do: neither spins on.
struct Pause {
  bool yields = false;
  std::chrono::nanoseconds sleeps{0};
  bool operator==(const Pause&) const = default;
};

/// For the wait of that number since there was work, from 1: it spins some times, yields `yields` times, then
/// sleeps, ever longer up to `longest`.
Pause pause_after(long waits, long yields, std::chrono::nanoseconds longest);

/// While a frame is under way a message may come at any time.
inline constexpr std::chrono::nanoseconds longest_amid_frame{200'000};
/// Where sleep ends when there is news.
inline constexpr std::chrono::nanoseconds longest_with_news{10'000'000};
/// Between frames only an announcement can come. It goes down a tree of the ranks (net/layout.hpp), and each
/// may sleep when it comes, so deep trees sleep less: an announcement reaches the last rank within 4 ms,
/// until where that would cost more than sleeping amid a frame does.
std::chrono::nanoseconds longest_between_frames(int ranks);

}  // namespace ringsplat
