#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "ringsplat/base/bytes.hpp"

namespace ringsplat {

/// What a rank hosts. `host` stands for the rank itself (announcements go to ranks, not to nodes).
enum class Role : std::uint8_t { gp, renderer, frame_buffer, host };

struct NodeId {
  Role role = Role::host;
  std::int32_t index = 0;
  bool operator==(const NodeId&) const = default;
};
inline constexpr NodeId frame_buffer_id{Role::frame_buffer, 0};
std::string to_string(NodeId id);  ///< "GP 3", "Renderer 0", "frame buffer", "rank 2"

enum class Kind : std::uint8_t {
  frame_spec,  ///< rank 0 → every rank, along a binomial tree: a frame begins
  token,    ///< GP → GP: permission to send `step`'s payload to Renderer `index` (the header's `renderer`)
  payload,  ///< GP → Renderer: one slice's bytes for one Renderer
  accept,   ///< Renderer → GP: the payload has a slot
  frame_end,  ///< last GP → Renderer: the frame has `sequence` payloads
  tile,       ///< Renderer → frame buffer: one finished region
  report,     ///< GP or Renderer → frame buffer: this node's part of the frame is over, with its counts
  shutdown,   ///< rank 0 → every rank, along the tree: no more frames
  stall,      ///< any rank → every rank: nothing moves; say what you wait for
  credit,  ///< rank → neighbour in a mesh: `sequence` slots of channel `region` (of its links to me) are free
           ///< again
  link_query,   ///< rank 0 → every rank, along the tree: a frame is complete; what did your links carry for
                ///< it?
  link_report,  ///< rank → frame buffer: the answer
  drop  ///< rank 0 → every rank, along the tree: nobody wants the frame any more; end it without its slices
};
inline constexpr std::uint8_t kinds = 13;
const char* name(Kind kind);

/// The fields every message carries. Sent as it is: ranks of one run share their byte order.
struct Header {
  std::uint32_t magic = 0x31505352;  // "RSP1"
  Kind kind = Kind::token;
  Role source_role = Role::host, destination_role = Role::host;
  std::uint8_t counted = 0;  ///< 1: a payload of which only the first counted_bytes say anything (simulation)
  std::int32_t source = 0, destination = 0;  ///< index within the role
  std::int64_t frame = 0;
  std::int32_t step = 0;       ///< traversal step of tokens, payloads and accepts
  std::int32_t renderer = 0;   ///< whose token, payload or accept this is
  std::uint32_t sequence = 0;  ///< tokens: the next one; payloads, accepts: this one; frame_end: how many
  /// Of a tile; the channel of a credit; the number of a payload's passes; of a token, the payloads that may
  /// be sent before one must be accepted; of an accept, the slots that are left for those behind it.
  std::uint32_t region = 0;
  std::uint64_t bytes = 0;  ///< of the body

  NodeId from() const { return {source_role, source}; }
  NodeId to() const { return {destination_role, destination}; }
};
static_assert(sizeof(Header) == 48);
inline constexpr std::size_t counted_bytes = 64;  ///< of the message, header included

/// A header and its body. `wire` holds room for the header and then the body, so that a
/// message leaves as one block without a copy; it is empty when there is no body.
class Message {
 public:
  Message() = default;
  explicit Message(const Header& h) : header(h) { header.bytes = 0; }
  /// `wire` must come from body_buffer(): room for the header, then the body.
  Message(const Header& h, Bytes wire);
  /// Takes a received block apart. Throws RunError when it is no message or its length is not what it says.
  static Message from_wire(Bytes block, int from_rank);
  /// The header of a received block, of which the end may still be missing. Throws RunError when it is none.
  static Header header_of(std::span<const std::byte> block, int from_rank);

  /// An empty body to append to.
  static Bytes body_buffer() { return Bytes(sizeof(Header)); }
  static std::size_t body_size(const Bytes& wire) {
    return wire.size() < sizeof(Header) ? 0 : wire.size() - sizeof(Header);
  }

  std::span<const std::byte> body() const;
  /// The block to send; writes the header into it. Valid until the message changes.
  std::span<const std::byte> seal();

  Header header;

 private:
  Bytes wire_;
};

}  // namespace ringsplat
