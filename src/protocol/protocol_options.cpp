#include "protocol/protocol_options.hpp"

#include <fmt/format.h>

#include "ringsplat/base/error.hpp"

namespace ringsplat {

void check(const ProtocolOptions& options) {
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
