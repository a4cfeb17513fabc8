#include "mpi/pauses.hpp"

#include <algorithm>
#include <bit>

namespace ringsplat {

Pause pause_after(long waits, long yields, std::chrono::nanoseconds longest) {
  constexpr long spins = 32, sleeps_of_a_length = 16;
  constexpr std::chrono::nanoseconds shortest{20'000};
  if (waits <= spins) return {};
  if (waits <= spins + yields) return {.yields = true};
  // A rank that has waited this long should leave its core to others.
  const long length = 1 + (waits - spins - yields) / sleeps_of_a_length, amid = longest_amid_frame / shortest;
  if (length <= amid) return {.sleeps = std::min(longest, shortest * length)};
  constexpr long most_doublings = 10;
  return {.sleeps = std::min(longest, longest_amid_frame * (1L << std::min(length - amid, most_doublings)))};
}

std::chrono::nanoseconds longest_between_frames(int ranks) {
  constexpr std::chrono::nanoseconds most{4'000'000}, to_the_last{4'000'000};
  const int depth = std::bit_width(static_cast<unsigned>(std::max(ranks, 1) - 1));
  return std::clamp(to_the_last / std::max(depth, 1), longest_amid_frame, most);
}

}  // namespace ringsplat
