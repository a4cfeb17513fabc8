#include "net/link_counts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/archive.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

LinkCounts& LinkCounts::operator+=(const LinkCounts& other) {
  messages += other.messages;
  bytes += other.bytes;
  payloads += other.payloads;
  payload_bytes += other.payload_bytes;
  shared += other.shared;
  waited += other.waited;
  wait_seconds += other.wait_seconds;
  return *this;
}

LinkCounts total(const std::vector<LinkCounts>& links) {
  LinkCounts sum;
  for (const auto& link : links) sum += link;
  return sum;
}

Bytes encode(const std::vector<LinkCounts>& counts) {
  ToBytes body{Message::body_buffer()};
  body(counts);
  return std::move(body.bytes);
}

std::vector<LinkCounts> decode_link_counts(std::span<const std::byte> body, const Layout& mesh, int rank) {
  const auto counts = from_bytes<std::vector<LinkCounts>>(body);
  const auto expected = links_from(mesh, rank);
  if (!counts || !std::equal(counts->begin(), counts->end(), expected.begin(), expected.end(),
                             [](const LinkCounts& c, const Link& link) { return c.link == link; }))
    throw RunError(fmt::format("rank {} sent a link report of {} bytes that is not about its {} link(s)",
                               rank, body.size(), expected.size()),
                   "all ranks must run the same build");
  return *counts;
}

}  // namespace ringsplat
