// One rank among others that the test plays, and the end of a run.
#include <fmt/format.h>

#include "node/nodes.hpp"
#include "node/views.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/net/loopback.hpp"
#include "ringsplat/node/host.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::test;
using Catch::Matchers::Contains;

namespace {

const Grid grid = make_grid({9, 9, 9});

FrameSpec solid() {
  FrameSpec spec = oblique_view(48, 48, 16);
  spec.transfer_function = constant_opacity(0.5);
  spec.dealt_to = 1;
  return spec;
}

/// Rank 1 of three, on which GP 1 lives.
class SecondRank {
 public:
  SecondRank() : network_(layout_.ranks()) {
    const auto source = synth_source("constant", grid);
    auto stores = dealt(*source, layout_.gps);
    host_.emplace(layout_, ProtocolOptions{}, grid, network_.transport(1), std::move(stores.at(1)),
                  Director{});
  }
  void announce(std::int64_t frame) {
    FrameSpec spec = solid();
    spec.frame = frame;
    const Bytes encoded = encode(spec);
    Bytes body = Message::body_buffer();
    body.insert(body.end(), encoded.begin(), encoded.end());
    send(Message({.kind = Kind::frame_spec, .source_role = Role::frame_buffer, .frame = frame},
                 std::move(body)));
  }
  void drop(std::int64_t frame) {
    send(Message({.kind = Kind::drop, .source_role = Role::frame_buffer, .frame = frame}));
  }
  void token(int step, int renderer, std::int64_t frame = 0) {
    send(Message({.kind = Kind::token,
                  .source_role = Role::gp,
                  .destination_role = Role::gp,
                  .source = 0,
                  .destination = 1,
                  .frame = frame,
                  .step = step,
                  .renderer = renderer}));
  }
  void work() {
    while (host_->step()) {
    }
  }
  /// What has been sent to the ranks of GP 0 and of the Renderer.
  std::vector<Message> sent() {
    std::vector<Message> all;
    for (const int rank : {0, 2})
      while (auto message = network_.transport(rank).receive()) all.push_back(std::move(*message));
    return all;
  }
  /// The first step of a traversal whose slice is GP 1's.
  static int own_step() {
    const FrameGeometry geometry = make_geometry(solid(), grid);
    return geometry.traversal.slice_at(0, geometry.slices) % 2 == 1 ? 0 : 1;
  }

 private:
  void send(Message message) {
    message.header.destination = 1;
    if (message.header.kind != Kind::token) message.header.destination_role = Role::host;
    network_.transport(0).send(1, std::move(message));
    work();
  }
  Layout layout_{2, 1};
  LoopbackNetwork network_;
  std::optional<Host> host_;
};

}  // namespace

TEST_CASE("a drop that overtakes its frame's announcement still drops it") {
  const int step = SecondRank::own_step();
  for (const bool early : {true, false}) {
    INFO((early ? "before" : "after") << " the announcement");
    SecondRank rank;
    if (early) rank.drop(0);
    rank.announce(0);
    if (!early) rank.drop(0);
    rank.token(step, 0);
    const auto sent = rank.sent();
    REQUIRE(sent.size() == 1);  // the payload stays, the token goes on
    CHECK(sent.front().header.kind == Kind::token);
  }
  SecondRank rank;
  rank.announce(0);
  rank.token(step, 0);
  const auto sent = rank.sent();
  REQUIRE(sent.size() == 1);
  CHECK(sent.front().header.kind == Kind::payload);
}

TEST_CASE("announcements that overtake each other reach the nodes in their order") {
  SecondRank rank;
  rank.announce(1);
  rank.token(SecondRank::own_step(), 0, 0);
  CHECK(rank.sent().empty());
  rank.announce(0);
  const auto sent = rank.sent();
  REQUIRE(sent.size() == 1);
  CHECK(sent.front().header.frame == 0);
}

TEST_CASE("a message about a node that the run does not have ends it") {
  SecondRank rank;
  rank.announce(0);
  CHECK_THROWS_WITH(rank.token(SecondRank::own_step(), 7), Contains("Renderer 7"));
}

TEST_CASE("when all ranks of a mesh have finished nothing is left in the network") {
  const auto source = synth_source("jack", make_grid({9, 8, 7}));
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Layout mesh = mesh_layout(3, 2, 4);
    LoopbackNetwork network(mesh.ranks(), {.seed = seed, .reorder = true, .max_delay = int(seed % 9)});
    auto stores = dealt(*source, mesh.gps);
    int asked = 0, done = 0;
    std::vector<std::unique_ptr<Host>> hosts;
    for (int rank = 0; rank < mesh.ranks(); ++rank) {
      Director director;
      if (rank == 0)
        director = {[&]() -> std::optional<FrameSpec> {
                      return asked++ < 2 ? std::optional(oblique_view(32, 32, 8)) : std::nullopt;
                    },
                    [&](FrameResult&&) { ++done; }};
      hosts.push_back(std::make_unique<Host>(mesh, ProtocolOptions{.link_slots = 2}, source->grid(),
                                             network.transport(rank),
                                             rank < mesh.gps ? std::move(stores.at(rank)) : SliceStore(),
                                             std::move(director)));
    }
    const auto all_finished = [&] {
      return std::all_of(hosts.begin(), hosts.end(), [](const auto& host) { return host->finished(); });
    };
    for (int turn = 0; !all_finished(); ++turn) {
      REQUIRE(turn < 100000);
      // As a rank's own loop does: one that has finished takes nothing any more.
      for (const auto& host : hosts)
        if (!host->finished()) host->step();
      network.turn();
    }
    INFO("seed " << seed);
    CHECK(done == 2);
    CHECK_FALSE(network.in_flight());
  }
}
