#include <fmt/format.h>

#include <algorithm>

#include "program/launch.hpp"
#include "ringsplat/base/error.hpp"
#include "session/render.hpp"

namespace ringsplat::app {

std::string build_id() {
  return fmt::format("ringsplat {} with wire format {}", RINGSPLAT_VERSION, wire_format());
}

void require_same_build(std::span<const std::string> builds_by_rank) {
  const auto differs = [&](const std::string& build) { return build != builds_by_rank.front(); };
  const auto first = std::find_if(builds_by_rank.begin(), builds_by_rank.end(), differs);
  if (first == builds_by_rank.end()) return;
  throw InputError(fmt::format("rank {} runs another build: {}, rank 0 runs {}",
                               first - builds_by_rank.begin(), *first, builds_by_rank.front()),
                   "install the same build on all machines, and see that no other comes first in a PATH");
}

}  // namespace ringsplat::app
