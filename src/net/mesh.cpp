#include "net/mesh.hpp"

#include <fmt/format.h>
#include <algorithm>

#include "base/archive.hpp"

namespace ringsplat {
namespace {

int wrapped(int row, int rows) { return (row % rows + rows) % rows; }

/// The direction in which a message for `destination` leaves `rank`; nothing at the destination.
std::optional<Direction> next_direction(const Layout& mesh, int rank, NodeId destination) {
  const int to = mesh.rank_of(destination);
  if (to == rank) return std::nullopt;
  const MeshPlace here = place_of(mesh, rank), there = place_of(mesh, to);
  const bool on_renderer = rank >= mesh.gps;
  if (!on_renderer && here.y != there.y) {
    const bool down = !wraps(mesh) ? there.y > here.y
                      : destination.role == Role::renderer
                          ? destination.index < mesh.mesh_rows
                          : 2 * wrapped(there.y - here.y, mesh.mesh_rows) <= mesh.mesh_rows;
    return down ? Direction::south : Direction::north;
  }
  return there.x < here.x || (on_renderer && here.x == mesh.mesh_columns) ? Direction::west : Direction::east;
}

}  // namespace

MeshPlace place_of(const Layout& mesh, int rank) {
  if (rank < mesh.gps) return {rank % mesh.mesh_columns, rank / mesh.mesh_columns};
  const int renderer = rank - mesh.gps;
  return renderer < mesh.mesh_rows ? MeshPlace{-1, renderer}
                                   : MeshPlace{mesh.mesh_columns, renderer - mesh.mesh_rows};
}

bool wraps(const Layout& mesh) { return mesh.renderers > mesh.mesh_rows; }

std::optional<int> neighbour(const Layout& mesh, int rank, Direction direction) {
  auto [x, y] = place_of(mesh, rank);
  const int columns = mesh.mesh_columns, rows = mesh.mesh_rows;
  const bool vertical = direction == Direction::north || direction == Direction::south;
  if (vertical) {
    if (rank >= mesh.gps || rows == 1) return std::nullopt;
    y += direction == Direction::south ? 1 : -1;
    if (wraps(mesh)) y = wrapped(y, rows);
    if (y < 0 || y >= rows) return std::nullopt;
    return y * columns + x;
  }
  x += direction == Direction::east ? 1 : -1;
  if (x >= 0 && x < columns) return y * columns + x;
  const int renderer = x == -1 ? y : x == columns ? rows + y : mesh.renderers;
  if (renderer >= mesh.renderers) return std::nullopt;
  return mesh.rank_of({Role::renderer, renderer});
}

std::string name(const Layout& mesh, const Link& link) {
  const char letter = "WENS"[static_cast<int>(link.direction)];
  if (link.from >= mesh.gps) return fmt::format("R{}{}", link.from - mesh.gps, letter);
  const MeshPlace place = place_of(mesh, link.from);
  return fmt::format("x{}y{}{}", place.x, place.y, letter);
}

std::vector<Link> links_from(const Layout& mesh, int rank) {
  std::vector<Link> found;
  for (const Direction direction : all_directions)
    if (neighbour(mesh, rank, direction)) found.push_back({rank, direction});
  return found;
}

std::vector<Link> links(const Layout& mesh) {
  std::vector<Link> all;
  for (int rank = 0; rank < mesh.ranks(); ++rank)
    for (const Link& link : links_from(mesh, rank)) all.push_back(link);
  return all;
}

std::vector<Hop> route(const Layout& mesh, NodeId source, NodeId destination) {
  std::vector<Hop> hops;
  int at = mesh.rank_of(source);
  const int first_row = place_of(mesh, at).y;
  while (const auto direction = next_direction(mesh, at, destination)) {
    Hop hop{{at, *direction}, neighbour(mesh, at, *direction).value(), 0};
    const int row = place_of(mesh, hop.to).y;
    // A message going down is above its first row only after it has passed the seam.
    if (*direction == Direction::south) hop.buffer_class = row < first_row ? 1 : 0;
    if (*direction == Direction::north) hop.buffer_class = row > first_row ? 1 : 0;
    at = hop.to;
    hops.push_back(hop);
  }
  return hops;
}

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
    throw OtherBuild(fmt::format("rank {} sent a link report of {} bytes that is not about its {} link(s)",
                                 rank, body.size(), expected.size()));
  return *counts;
}

}  // namespace ringsplat
