#pragma once
#include <simgrid/s4u.hpp>

#include <string>

namespace ringsplat::simgrid_platform {

/// Files to write at the end of a simulation; an empty name writes nothing.
struct MonitorFiles {
  std::string links;      ///< CSV, a line for each link: link, payloads, bytes, busy seconds, overlaps
  std::string transfers;  ///< CSV, a line for each payload: start, bytes, seconds alone, seconds taken
};

/// Records each payload's transfer as SimGrid reports it, and writes `files` at the end.
///
/// With a `speedup` above 1 all links are that many times as fast as described. Each transfer then gets as
/// latency the time it would take alone on the described links, so that none slows another.
///
/// Alone, a transfer holds its links from start + latency for size / bandwidth seconds. A payload that finds
/// another one on a link in that time is an overlap, counted on that link for the later one. Without overlaps
/// no payload slows another; it takes its time alone, unless it meets messages without a payload.
void watch_links(simgrid::s4u::NetZone* zone, double speedup, MonitorFiles files);

/// Makes SimGrid copy only the first bytes of payloads that only count (counted_magic); it still charges
/// their true size. Otherwise a large volume's frame moves hundreds of gigabytes through this machine's
/// memory.
void copy_only_what_counts();

}  // namespace ringsplat::simgrid_platform
