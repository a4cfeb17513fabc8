#include "net/message.hpp"

#include <fmt/format.h>

#include "base/byte_stream.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

std::string to_string(NodeId id) {
  constexpr const char* names[] = {"GP", "Renderer", "frame buffer", "rank"};
  const std::string name = names[static_cast<int>(id.role)];
  return id.role == Role::frame_buffer ? name : fmt::format("{} {}", name, id.index);
}

const char* name(Kind kind) {
  static constexpr const char* names[kinds] = {
      "announcement", "token", "payload", "accept",     "frame end",   "tile", "report",
      "shutdown",     "stall", "credit",  "link query", "link report", "drop", "pixels"};
  const auto index = static_cast<std::uint8_t>(kind);
  return index < kinds ? names[index] : "unknown";
}

Header make_header(Kind kind, NodeId from, NodeId to, std::int64_t frame) {
  return {.kind = kind,
          .source_role = from.role,
          .destination_role = to.role,
          .source = from.index,
          .destination = to.index,
          .frame = frame};
}

std::optional<TokenPlace> token_place(const Header& header) {
  if (header.kind == Kind::token) return fields_of<TokenFields>(header).place;
  if (header.kind == Kind::payload) return fields_of<PayloadFields>(header).place;
  if (header.kind == Kind::accept) return fields_of<AcceptFields>(header).place;
  return std::nullopt;
}

Header Message::header_of(std::span<const std::byte> block, int from_rank) {
  if (block.size() < sizeof(Header))
    throw RunError(
        fmt::format("rank {} sent a message of {} bytes, shorter than a header", from_rank, block.size()));
  Header h;
  std::memcpy(&h, block.data(), sizeof(Header));
  if (h.magic != Header{}.magic || static_cast<std::uint8_t>(h.kind) >= kinds || h.source_role > Role::host ||
      h.destination_role > Role::host)
    throw OtherBuild(fmt::format("rank {} sent bytes that are no Ringsplat message", from_rank));
  return h;
}

Message Message::from_wire(Bytes block, int from_rank) {
  Message message;
  message.header = header_of(block, from_rank);
  const Header& h = message.header;
  if (h.bytes != block.size() - sizeof(Header))
    throw RunError(fmt::format("rank {} sent a {} of {} bytes that says it has {}", from_rank, name(h.kind),
                               block.size() - sizeof(Header), h.bytes));
  message.wire_ = std::move(block);
  return message;
}

}  // namespace ringsplat
