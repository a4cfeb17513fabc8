#pragma once
#include <cstdint>
#include <vector>

#include "net/mesh.hpp"

namespace ringsplat {

/// What one directed link carried for one frame. Credits are not counted.
struct LinkCounts {
  Link link;
  std::uint64_t messages = 0, bytes = 0;          ///< headers included
  std::uint64_t payloads = 0, payload_bytes = 0;  ///< of these, splat messages
  std::uint64_t shared = 0;  ///< messages that found another one on the link or waiting for it
  std::uint64_t waited = 0;  ///< messages that had to wait because all slots behind the link were taken
  double wait_seconds = 0;   ///< how long, in sum

  /// Adds all but the link itself.
  LinkCounts& operator+=(const LinkCounts& other);
};
LinkCounts total(const std::vector<LinkCounts>& links);

/// The body of a link_report (base/archive.hpp) and back. Throws RunError unless the bytes are counts of
/// exactly the links that leave `rank`.
Bytes encode(const std::vector<LinkCounts>& counts);
std::vector<LinkCounts> decode_link_counts(std::span<const std::byte> body, const Layout& mesh, int rank);

}  // namespace ringsplat
