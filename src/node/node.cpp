#include "ringsplat/node/node.hpp"

#include <fmt/format.h>

#include "ringsplat/base/error.hpp"
#include "ringsplat/base/thread_team.hpp"

namespace ringsplat {

void check(const ProtocolOptions& options) {
  const auto at_least_one = [](const char* option, int value) {
    if (value < 1) throw InputError(fmt::format("{} is {}", option, value), "it must be at least 1");
  };
  at_least_one("--frames-in-flight", options.frames_in_flight);
  at_least_one("--slots", options.slots);
  at_least_one("--link-slots", options.link_slots);
  at_least_one("--look-ahead", options.look_ahead);
  if (options.send_ahead < 0)
    throw InputError(fmt::format("--send-ahead is {}", options.send_ahead), "it must be at least 0");
  at_least_one("--threads-per-rank", options.threads_per_rank);
  if (options.threads_per_rank > ThreadTeam::most_threads)
    throw InputError(
        fmt::format("--threads-per-rank is {}, more than a rank can use", options.threads_per_rank),
        fmt::format("use one for each core of a rank, at most {}", ThreadTeam::most_threads));
  if (!(options.stall_timeout > 0))
    throw InputError(fmt::format("--stall-timeout is {}", options.stall_timeout),
                     "it is a number of seconds above 0");
}

}  // namespace ringsplat
