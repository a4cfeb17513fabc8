#include "protocol/node.hpp"

#include <fmt/format.h>

#include <utility>

#include "base/byte_stream.hpp"
#include "base/process.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

void refuse(NodeId node, const Header& h) {
  throw RunError(
      fmt::format("{} cannot use a {} (from {})", to_string(node), name(h.kind), to_string(h.from())));
}

Message make_report(NodeId node, std::int64_t frame, NodeStats stats) {
  stats.peak_memory = peak_memory_bytes();
  Bytes body = Message::body_buffer();
  append(body, stats);
  return Message(make_header(Kind::report, node, frame_buffer_id, frame), std::move(body));
}

}  // namespace ringsplat
