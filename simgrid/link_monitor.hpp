#pragma once
#include <simgrid/s4u.hpp>
#include <string>

#include "ringsplat/net/layout.hpp"

namespace ringsplat::simgrid_platform {

/// Notes when each payload holds each link of its way, from what SimGrid itself says when a transfer starts,
/// and writes at the end a line for each link: link, payloads, bytes, busy seconds, overlaps.
///
/// A transfer holds its links from start + latency for size / bandwidth seconds. Where no two such intervals
/// on a link overlap, no transfer was ever slowed, and the intervals are exact. An overlap is counted for the
/// later transfer. Payloads are what goes from a GP's host to a Renderer's and is longer than any message
/// without a body.
void watch_links(simgrid::s4u::NetZone* zone, const Layout& layout, std::string file);

}  // namespace ringsplat::simgrid_platform
