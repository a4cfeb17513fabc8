#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "net/message.hpp"

/// The mesh of Neumann 1992, section 3.1, as pure functions of the layout, the same on every rank.
///
/// A message travels along its column to its destination's row and then along that row (manhattan routing).
/// Where the mesh wraps, messages to Renderers on the right go up and messages to Renderers on the left go
/// down; messages to GPs take the shorter way, down when both are as long.
///
/// Why payloads never contend while tokens move in step: docs/protocol.md, Mesh.
///
/// Hops, the last one into the Renderer included: |rows| + |columns| + 1 without wrap; with it the rows are
/// counted in the direction of travel, modulo N.
namespace ringsplat {

enum class Direction : std::uint8_t { west, east, north, south };  // left, right, up, down on the page
inline constexpr std::array all_directions{Direction::west, Direction::east, Direction::north,
                                           Direction::south};

/// A rank's place. GPs: 0 ≤ x < columns; Renderers: x = −1 or x = columns.
struct MeshPlace {
  int x = 0, y = 0;
  bool operator==(const MeshPlace&) const = default;
};
MeshPlace place_of(const Layout& mesh, int rank);

/// True when the top row and the bottom row are neighbours: Renderers stand on both sides.
bool wraps(const Layout& mesh);

/// The rank at the other end of a link, if `rank` has one there. In a wrapped mesh of two rows, north and
/// south lead to the same rank over links of their own; one row has no vertical links.
std::optional<int> neighbour(const Layout& mesh, int rank, Direction direction);

/// A directed link, named by the rank it leaves.
struct Link {
  int from = 0;
  Direction direction = Direction::west;
  auto operator<=>(const Link&) const = default;
};
/// "x1y2N" leaves the GP in column 1, row 2 upwards; "R5W" leaves Renderer 5 to the left.
std::string name(const Layout& mesh, const Link& link);
/// All directed links, by rank.
std::vector<Link> links(const Layout& mesh);
/// Those that leave one rank.
std::vector<Link> links_from(const Layout& mesh, int rank);

/// Number of buffer classes of a link; see `Hop::buffer_class`.
inline constexpr int buffer_classes = 2;

/// One link of a route.
struct Hop {
  Link link;
  int to = 0;  ///< rank
  /// 0 before, and 1 from, the hop over the seam between the bottom and the top row. This "dateline" (Dally
  /// and Seitz 1987) keeps messages that follow each other round a wrapped column from all waiting for the
  /// next.
  int buffer_class = 0;
  bool operator==(const Hop&) const = default;
};

/// The way of a message from node to node; empty when they share a rank.
std::vector<Hop> route(const Layout& mesh, NodeId source, NodeId destination);

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
