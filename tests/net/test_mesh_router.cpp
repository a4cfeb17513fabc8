#include "net/mesh_transport.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <random>
#include <set>

#include "net/loopback.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

/// The routers of all ranks over a loopback, with the messages they deliver.
struct Mesh {
  Mesh(const Layout& mesh, int slots, const LoopbackOptions& loopback)
      : layout(mesh), network(mesh.ranks(), loopback) {
    for (int r = 0; r < mesh.ranks(); ++r)
      routers.push_back(std::make_unique<MeshRouter>(mesh, slots, network.transport(r)));
  }

  /// One round of all ranks but `stopped`; false when nothing was received.
  bool turn(int stopped = -1) {
    bool moved = false;
    for (int r = 0; r < layout.ranks(); ++r) {
      if (r == stopped) continue;
      while (auto message = network.transport(r).receive()) {
        moved = true;
        if (auto mine = routers[std::size_t(r)]->take(std::move(*message)))
          delivered.push_back(std::move(*mine));
      }
      routers[std::size_t(r)]->return_credits();
    }
    network.turn();
    return moved;
  }

  void post(NodeId from, NodeId to, std::uint32_t sequence, std::size_t bytes) {
    Bytes body = Message::body_buffer();
    body.resize(body.size() + bytes, std::byte(sequence));
    Message message(make_header(from, to, 0, PayloadFields{.place = {.sequence = sequence}}),
                    std::move(body));
    routers[std::size_t(layout.rank_of(from))]->post(std::move(message));
  }

  bool idle() const {
    return std::all_of(routers.begin(), routers.end(), [](const auto& r) { return r->idle(); });
  }

  Layout layout;
  LoopbackNetwork network;
  std::vector<std::unique_ptr<MeshRouter>> routers;
  std::vector<Message> delivered;
};

NodeId random_node(const Layout& mesh, std::mt19937& random) {
  const int rank = int(random() % unsigned(mesh.ranks()));
  return mesh.nodes_on(rank).front();
}

Message credit(int from, int to, const CreditFields& fields) {
  return Message(make_header({Role::host, from}, {Role::host, to}, 0, fields));
}

}  // namespace

TEST_CASE("with one slot a link, a flood between random nodes drains, nothing is lost or changed") {
  for (const Layout& mesh : {mesh_layout(2, 2, 4), mesh_layout(3, 3, 3), mesh_layout(3, 3, 6),
                             mesh_layout(4, 4, 8), mesh_layout(2, 5, 10)})
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      INFO(fmt::format("{}x{}+{}, seed {}", mesh.mesh_columns, mesh.mesh_rows, mesh.renderers, seed));
      Mesh net(mesh, 1, {.seed = seed, .reorder = true, .max_delay = int(seed % 5)});
      std::mt19937 random(unsigned(seed) + 1);
      constexpr std::uint32_t flood = 2000;
      std::vector<std::pair<NodeId, std::size_t>> sent;
      std::uint64_t hops = 0, bytes = 0;
      while (sent.size() < flood) {
        const NodeId from = random_node(mesh, random), to = random_node(mesh, random);
        if (from == to) continue;
        const std::size_t size = random() % 50;
        const auto way = route(mesh, from, to).size();
        hops += way;
        bytes += way * (size + sizeof(Header));
        net.post(from, to, std::uint32_t(sent.size()), size);
        sent.emplace_back(to, size);
      }
      for (int quiet = 0; quiet < 10;) quiet = net.turn() ? 0 : quiet + 1;
      REQUIRE(net.delivered.size() == flood);
      REQUIRE(net.idle());
      std::set<std::uint32_t> arrived;
      for (const Message& message : net.delivered) {
        const auto sequence = token_place(message.header)->sequence;
        REQUIRE(arrived.insert(sequence).second);
        REQUIRE(message.header.to() == sent[sequence].first);
        REQUIRE(message.body().size() == sent[sequence].second);
        for (const auto b : message.body()) REQUIRE(b == std::byte(sequence));
      }
      LinkCounts sum;
      for (const auto& router : net.routers) sum += total(router->take_counts(0));
      CHECK(sum.messages == hops);
      CHECK(sum.bytes == bytes);
      CHECK(sum.payloads == hops);
      CHECK(sum.waited > 0);
      CHECK(sum.wait_seconds > 0);
      CHECK(sum.shared >= sum.waited);
    }
}

TEST_CASE("a link carries no more messages at once than it has slots, and the others wait for it") {
  const Layout mesh = mesh_layout(3, 1, 1);
  for (const int slots : {1, 2, 5}) {
    LoopbackNetwork network(mesh.ranks());
    int started = 0;
    MeshRouter sender(mesh, slots, network.transport(2), [&](const Link&, const Header&) { ++started; });
    for (int k = 0; k < 7; ++k)
      sender.post(Message({.kind = Kind::token,
                           .source_role = Role::gp,
                           .destination_role = Role::gp,
                           .source = 2,
                           .destination = 0}));
    CHECK(started == slots);
    const auto counts = sender.take_counts(0);
    REQUIRE(counts.size() == 1);
    CHECK(counts[0].messages == 7);
    CHECK(counts[0].shared == 6);
    CHECK(counts[0].waited == std::uint64_t(7 - slots));
    sender.take(credit(1, 2, {.channel = 0, .slots = 1}));
    CHECK(started == slots + 1);
    if (slots == 1) continue;
    // Several slots may come back at once, for as many messages.
    sender.take(credit(1, 2, {.channel = 0, .slots = 2}));
    CHECK(started == std::min(slots + 3, 7));
  }
}

TEST_CASE("a rank that stops is named by those that wait for it") {
  const Layout mesh = mesh_layout(4, 1, 1);
  Mesh net(mesh, 1, {});
  for (std::uint32_t k = 0; k < 4; ++k) net.post({Role::gp, 3}, {Role::renderer, 0}, k, 10);
  constexpr int stopped = 1;
  while (net.turn(stopped)) {
  }
  CHECK(net.delivered.empty());
  CHECK(net.routers[2]->waiting_for().find("link x2y0W") != std::string::npos);
  CHECK(net.routers[2]->waiting_for().find("for rank 1") != std::string::npos);
  CHECK(net.routers[3]->waiting_for().find("for rank 2") != std::string::npos);
  CHECK(net.routers[3]->waiting_for().find("payload from GP 3 to Renderer 0") != std::string::npos);
  CHECK(net.routers[0]->waiting_for().empty());
  while (net.turn()) {
  }
  CHECK(net.delivered.size() == 4);
}

TEST_CASE("messages that cannot be are refused: off their route, credits that are not owed") {
  const Layout mesh = mesh_layout(3, 3, 6);
  LoopbackNetwork network(mesh.ranks());
  MeshRouter router(mesh, 2, network.transport(4));
  CHECK_THROWS_AS(router.take(Message({.kind = Kind::token,
                                       .source_role = Role::gp,
                                       .destination_role = Role::gp,
                                       .source = 0,
                                       .destination = 1})),
                  RunError);
  CHECK_THROWS_AS(router.take(credit(1, 4, {.channel = 0, .slots = 1})), RunError);
  CHECK_THROWS_AS(router.take(credit(3, 4, {.channel = 0, .slots = 1})), RunError);
  CHECK_THROWS_AS(router.take(credit(3, 4, {.channel = 999, .slots = 0})), RunError);
  CHECK(router.idle());
}

TEST_CASE("link counts survive their message and wrong ones are refused") {
  const Layout mesh = mesh_layout(2, 2, 2);
  LoopbackNetwork network(mesh.ranks());
  MeshRouter router(mesh, 1, network.transport(1));
  auto counts = router.take_counts(0);
  REQUIRE(counts.size() == 2);
  counts[0].messages = 5;
  counts[1].wait_seconds = 0.25;
  const Message message({.kind = Kind::link_report}, encode(counts));
  const auto back = decode_link_counts(message.body(), mesh, 1);
  CHECK(total(back).messages == 5);
  CHECK(total(back).wait_seconds == 0.25);
  CHECK_THROWS_AS(decode_link_counts(message.body(), mesh, 0), RunError);
  CHECK_THROWS_AS(decode_link_counts(message.body().first(message.body().size() - 1), mesh, 1), RunError);
}
