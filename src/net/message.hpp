#pragma once
#include <array>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "ringsplat/base/bytes.hpp"
#include "ringsplat/net/layout.hpp"

namespace ringsplat {

/// Kinds of nodes on a rank. `host` stands for the rank itself: announcements go to ranks, not to nodes.
enum class Role : std::uint8_t { gp, renderer, frame_buffer, host };

struct NodeId {
  Role role = Role::host;
  std::int32_t index = 0;
  bool operator==(const NodeId&) const = default;
};
inline constexpr NodeId frame_buffer_id{Role::frame_buffer, 0};
std::string to_string(NodeId id);  ///< "GP 3", "Renderer 0", "frame buffer", "rank 2"

enum class Kind : std::uint8_t {
  announcement,  ///< rank 0 → every rank, along a binomial tree: a frame begins
  token,         ///< GP → GP: permission to send a step's payload to one Renderer
  payload,       ///< GP → Renderer: one slice's bytes for one Renderer
  accept,        ///< Renderer → GP: the payload has a slot
  frame_end,     ///< last GP → Renderer: all payloads of the frame were sent
  tile,          ///< Renderer → frame buffer: one finished tile
  report,        ///< GP or Renderer → frame buffer: this node's part of the frame is over, with its counts
  shutdown,      ///< rank 0 → every rank, along the tree: no more frames
  stall,         ///< any rank → every rank: nothing moves; say what you wait for
  credit,        ///< rank → neighbour in a mesh: slots of one of its links to me are free again
  link_query,    ///< rank 0 → every rank, along the tree: a frame is complete; what did your links carry?
  link_report,   ///< rank → frame buffer: the answer
  drop,  ///< rank 0 → every rank, along the tree: nobody wants the frame any more; end it without its slices
  pixels  ///< Renderer → Renderer, straight in a mesh, too: drawn layers of the receiver's tiles
};
inline constexpr std::uint8_t kinds = 14;
const char* name(Kind kind);

/// Which token, payload or accept a message is about.
struct TokenPlace {
  std::int32_t step = 0;       ///< of the traversal
  std::int32_t renderer = 0;   ///< whose token or payload it is
  std::uint32_t sequence = 0;  ///< a payload's own (an accept's: of its payload); of a token the next
                               ///< payload's
};

// The header's fields of each kind. A kind without such a struct has none.

struct TokenFields {
  static constexpr Kind kind = Kind::token;
  TokenPlace place;
  std::uint32_t credits = 0;  ///< payloads that may be sent before one must be accepted
};
struct PayloadFields {
  static constexpr Kind kind = Kind::payload;
  TokenPlace place;
  std::uint32_t passes = 0;  ///< non-empty (region, pass) pairs in it (Neumann 1992, Fig. 3)
};
struct AcceptFields {
  static constexpr Kind kind = Kind::accept;
  TokenPlace place;
  std::uint32_t free_slots = 0;  ///< left behind this payload
};
struct FrameEndFields {
  static constexpr Kind kind = Kind::frame_end;
  std::uint32_t payloads = 0;  ///< that the Renderer gets for this frame
};
struct TileFields {
  static constexpr Kind kind = Kind::tile;
  std::int32_t tile = 0;
};
struct CreditFields {
  static constexpr Kind kind = Kind::credit;
  std::uint32_t channel = 0;  ///< one of the receiver's links to the sender, with its buffer class
  std::uint32_t slots = 0;    ///< freed slots of the channel
};

/// The header of every message. Sent as it is: ranks of one run share their byte order.
struct Header {
  std::uint32_t magic = 0x32505352;  // "RSP2"
  Kind kind = Kind::stall;
  Role source_role = Role::host, destination_role = Role::host;
  std::uint8_t unused = 0;
  std::int32_t source = 0, destination = 0;  ///< index within the role
  std::int64_t frame = 0;
  std::array<std::byte, 16> fields{};  ///< the kind's own: see fields_of()
  std::uint64_t bytes = 0;             ///< of the body

  NodeId from() const { return {source_role, source}; }
  NodeId to() const { return {destination_role, destination}; }
};
static_assert(sizeof(Header) == 48);

/// The header of a message of a kind without fields.
Header make_header(Kind kind, NodeId from, NodeId to, std::int64_t frame);

/// The header of a message of kind `Fields::kind`.
template <class Fields>
Header make_header(NodeId from, NodeId to, std::int64_t frame, const Fields& fields) {
  static_assert(std::is_trivially_copyable_v<Fields> && sizeof(Fields) <= sizeof(Header::fields));
  Header h = make_header(Fields::kind, from, to, frame);
  std::memcpy(h.fields.data(), &fields, sizeof fields);
  return h;
}

/// The fields of a header of kind `Fields::kind`; meaningless for another kind.
template <class Fields>
Fields fields_of(const Header& header) {
  assert(header.kind == Fields::kind);
  Fields fields;
  std::memcpy(&fields, header.fields.data(), sizeof fields);
  return fields;
}

/// The place that a token, a payload or an accept is about; nothing for other kinds.
std::optional<TokenPlace> token_place(const Header& header);

/// A header and its body. `wire` holds room for the header and then the body, so that a
/// message leaves as one block without a copy; it is empty when there is no body.
class Message {
 public:
  Message() = default;
  explicit Message(const Header& h) : header(h) { header.bytes = 0; }
  /// `wire` must come from body_buffer(): room for the header, then the body.
  Message(const Header& h, Bytes wire) : header(h), wire_(std::move(wire)) {
    header.bytes = body_size(wire_);
  }
  /// Parses a received block. Throws RunError when it is no message or has another length than it says.
  static Message from_wire(Bytes block, int from_rank);
  /// The header of a received block, whose end may still be missing. Throws RunError when it is no header.
  static Header header_of(std::span<const std::byte> block, int from_rank);

  /// An empty body to append to.
  static Bytes body_buffer() { return Bytes(sizeof(Header)); }
  static std::size_t body_size(const Bytes& wire) {
    return wire.size() < sizeof(Header) ? 0 : wire.size() - sizeof(Header);
  }

  std::span<const std::byte> body() const {
    if (wire_.size() <= sizeof(Header)) return {};
    return std::span<const std::byte>(wire_).subspan(sizeof(Header));
  }
  /// The block to send; writes the header into it. Valid until the message changes.
  std::span<const std::byte> seal() {
    if (wire_.empty()) wire_.resize(sizeof(Header));
    std::memcpy(wire_.data(), &header, sizeof(Header));
    return wire_;
  }

  Header header;

 private:
  Bytes wire_;
};

/// Throws RunError, naming the sender, when a header names nodes that the layout does not have.
void check(const Header& header, const Layout& layout);

/// The ranks to which `rank` passes an announcement that starts at rank 0 (binomial tree).
std::vector<int> announcement_children(int rank, int ranks);

}  // namespace ringsplat
