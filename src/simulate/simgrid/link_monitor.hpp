#pragma once
#include <simgrid/s4u.hpp>
#include <string>

namespace ringsplat::simgrid_platform {

/// What to write at the end of a simulation; an empty name writes nothing.
struct MonitorFiles {
  std::string links;      ///< CSV, a line for each link: link, payloads, bytes, busy seconds, overlaps
  std::string transfers;  ///< CSV, a line for each payload: start, bytes, seconds alone, seconds taken
};

/// Notes what each payload did on its way, from what SimGrid itself says of its transfers, and writes `files`
/// at the end.
///
/// With a `speedup` above 1 all links are so much faster than described. Transfers are then given what they
/// would take alone on the described ones as a latency, so that none slows another.
///
/// Alone, a transfer holds its links from start + latency for size / bandwidth seconds; an overlap is a
/// payload that finds another one in that time, counted for the later one on each link. Where there is none,
/// no payload was slowed by another, and the seconds taken are those alone, unless it met messages without a
/// payload.
void watch_links(simgrid::s4u::NetZone* zone, double speedup, MonitorFiles files);

}  // namespace ringsplat::simgrid_platform
