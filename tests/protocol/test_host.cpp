// One rank, with the test in place of the others, and the end of a run.
#include "protocol/rank.hpp"

#include <algorithm>
#include <deque>

#include "base/byte_stream.hpp"
#include "net/loopback.hpp"
#include "net/mesh.hpp"
#include "support/catch.hpp"
#include "toy_engine.hpp"

using namespace ringsplat;
using namespace ringsplat::test;
using Catch::Matchers::Contains;

namespace {

/// Rank 1 of three, which hosts GP 1; its first step is step 1.
class SecondRank {
 public:
  void announce(std::int64_t frame) {
    Bytes body = Message::body_buffer();
    append(body, ToyFrame{});
    give(make_header(Kind::announcement, frame_buffer_id, {Role::host, 1}, frame), std::move(body));
  }
  void drop(std::int64_t frame) { give(make_header(Kind::drop, frame_buffer_id, {Role::host, 1}, frame)); }
  void token(int step, int renderer = 0, std::int64_t frame = 0) {
    give(make_header({Role::gp, 0}, {Role::gp, 1}, frame,
                     TokenFields{.place = {.step = step, .renderer = renderer}}));
  }
  /// Gives it a message from rank 0 and lets it work.
  void give(const Header& header, Bytes body = {}) {
    network_.transport(0).send(1, Message(header, std::move(body)));
    while (host_.step()) {
    }
  }
  /// Messages sent to the ranks of GP 0 and of the Renderer.
  std::vector<Message> sent() {
    std::vector<Message> all;
    for (const int rank : {0, 2})
      while (auto message = network_.transport(rank).receive()) all.push_back(std::move(*message));
    return all;
  }
  bool finished() { return host_.finished(); }

 private:
  Layout layout_{2, 1};
  LoopbackNetwork network_{layout_.ranks()};
  ToyEngine engine_;
  Host host_{layout_, {}, network_.transport(1), engine_, nullptr};
};

}  // namespace

TEST_CASE("a drop that overtakes its frame's announcement still drops it") {
  for (const bool early : {true, false}) {
    INFO((early ? "before" : "after") << " the announcement");
    SecondRank rank;
    if (early) rank.drop(0);
    rank.announce(0);
    if (!early) rank.drop(0);
    rank.token(1);
    const auto sent = rank.sent();
    REQUIRE(sent.size() == 1);
    // What was encoded by then is sent.
    CHECK(sent.front().header.kind == (early ? Kind::token : Kind::payload));
  }
  SecondRank rank;
  rank.announce(0);
  rank.token(1);
  const auto sent = rank.sent();
  REQUIRE(sent.size() == 1);
  CHECK(sent.front().header.kind == Kind::payload);
}

TEST_CASE("messages of a frame not yet announced wait for it") {
  SecondRank rank;
  rank.token(1, 0, 1);
  rank.token(1);
  CHECK(rank.sent().empty());
  rank.announce(0);
  const auto sent = rank.sent();
  REQUIRE(sent.size() == 1);
  CHECK(sent.front().header.kind == Kind::payload);
  CHECK(sent.front().header.frame == 0);
}

TEST_CASE("announcements that overtake each other reach the nodes in their order") {
  SecondRank rank;
  rank.announce(1);
  rank.token(1);
  CHECK(rank.sent().empty());
  rank.announce(0);
  const auto sent = rank.sent();
  REQUIRE(sent.size() == 1);
  CHECK(sent.front().header.frame == 0);
}

TEST_CASE("a rank refuses messages about nodes that the run does not have or that live elsewhere") {
  SecondRank rank;
  rank.announce(0);
  CHECK_THROWS_WITH(rank.token(1, 7), Contains("Renderer 7"));
  CHECK_THROWS_WITH(rank.give(make_header({Role::gp, 1}, {Role::renderer, 0}, 0, PayloadFields{})),
                    Contains("rank 1 got a payload for Renderer 0, which it does not host"));
}

TEST_CASE("a rank has finished once it was told of the end, which is not handed on to it twice") {
  SecondRank rank;
  CHECK_FALSE(rank.finished());
  rank.give(make_header(Kind::shutdown, frame_buffer_id, {Role::host, 1}, 0));
  CHECK(rank.finished());
  CHECK(rank.sent().empty());
}

TEST_CASE("a rank of a mesh has not finished while a neighbour owes it credits") {
  const Layout mesh = mesh_layout(2, 1, 1);
  LoopbackNetwork network(mesh.ranks());
  ToyEngine engine;
  Host host(mesh, {}, network.transport(1), engine, nullptr);
  const auto give = [&](const Header& header, Bytes body = {}) {
    network.transport(0).send(1, Message(header, std::move(body)));
    while (host.step()) {
    }
  };
  // No Renderer has a tile, so that the GP reports at once, over the link to rank 0.
  Bytes body = Message::body_buffer();
  append(body, ToyFrame{.steps = 2, .gps = mesh.gps, .renderers = mesh.renderers, .tiles = 0});
  give(make_header(Kind::announcement, frame_buffer_id, {Role::host, 1}, 0), std::move(body));
  const auto report = network.transport(0).receive();
  REQUIRE(report);
  REQUIRE(report->header.kind == Kind::report);
  give(make_header(Kind::shutdown, frame_buffer_id, {Role::host, 1}, 0));
  CHECK_FALSE(host.finished());
  // What rank 0 sends for the report that it has taken.
  MeshRouter neighbour(mesh, ProtocolOptions{}.link_slots, network.transport(0));
  REQUIRE(neighbour.take(*report));
  neighbour.return_credits();
  while (host.step()) {
  }
  CHECK(host.finished());
}

TEST_CASE("when all ranks of a mesh have finished nothing is left in the network") {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Layout mesh = mesh_layout(3, 2, 4);
    LoopbackNetwork network(mesh.ranks(), {.seed = seed, .reorder = true, .max_delay = int(seed % 9)});
    const ToyFrame frame{.steps = 9, .gps = mesh.gps, .renderers = mesh.renderers, .tiles = mesh.renderers};
    ToyFrames frames({frame, frame});
    std::deque<ToyEngine> engines;
    std::vector<std::unique_ptr<Host>> ranks;
    for (int rank = 0; rank < mesh.ranks(); ++rank)
      ranks.push_back(std::make_unique<Host>(mesh, ProtocolOptions{.link_slots = 2}, network.transport(rank),
                                             engines.emplace_back(), rank == 0 ? &frames : nullptr));
    const auto all_finished = [&] {
      return std::all_of(ranks.begin(), ranks.end(), [](const auto& rank) { return rank->finished(); });
    };
    for (int turn = 0; !all_finished(); ++turn) {
      REQUIRE(turn < 100000);
      // As in a rank's own loop: a finished host receives nothing more.
      for (const auto& rank : ranks)
        if (!rank->finished()) rank->step();
      network.turn();
    }
    INFO("seed " << seed);
    CHECK(frames.over.size() == 2);
    CHECK_FALSE(network.in_flight());
  }
}
