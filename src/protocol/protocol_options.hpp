#pragma once
#include <fmt/format.h>

#include "ringsplat/base/error.hpp"
#include "ringsplat/net/layout.hpp"

namespace ringsplat {

class Trace;

/// How far frames, slices and payloads may run ahead; none of it changes a picture.
struct ProtocolOptions {
  int frames_in_flight = 2;  ///< frames announced and not yet complete
  int slots = 4;             ///< payloads of one frame that a Renderer holds accepted and not drawn
  int link_slots = 4;  ///< messages of one buffer class stored at the far end of a mesh link; 1 is enough
  int look_ahead = 1;  ///< slices a GP prepares before their tokens have passed; 1 is the paper
  int send_ahead = 0;  ///< unaccepted payloads that a token may leave behind, as long as its Renderer has
                       ///< slots; 0 is the paper; rings only
  double stall_timeout = 60;  ///< seconds without progress before ranks say who waits for whom
  bool stall_ends = true;     ///< then the run fails; else it waits on
  Trace* trace = nullptr;     ///< records what the nodes of this process do; must outlive them
};

/// How far ranks that draw sheets run ahead of tokens, so that they wait less for those that something else
/// keeps from running (docs/performance.md).
constexpr ProtocolOptions running_ahead(Topology topology) {
  return {.slots = 16, .look_ahead = 4, .send_ahead = topology == Topology::ring ? 16 : 0};
}

/// Throws InputError naming the option when a number is below 1 (or the timeout not positive).
inline void check(const ProtocolOptions& options) {
  const auto at_least = [](const char* option, int value, int least) {
    if (value < least)
      throw InputError(fmt::format("{} is {}", option, value), fmt::format("it must be at least {}", least));
  };
  at_least("--frames-in-flight", options.frames_in_flight, 1);
  at_least("--slots", options.slots, 1);
  at_least("--link-slots", options.link_slots, 1);
  at_least("--look-ahead", options.look_ahead, 1);
  at_least("--send-ahead", options.send_ahead, 0);
  if (!(options.stall_timeout > 0))
    throw InputError(fmt::format("--stall-timeout is {}", options.stall_timeout),
                     "it is a number of seconds above 0");
}

}  // namespace ringsplat
