// The mesh as a transport: what travels over it, and the counts that rank 0 collects.
#include "net/mesh_transport.hpp"

#include <memory>
#include <vector>

#include "net/loopback.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using Catch::Matchers::Contains;

namespace {

/// All ranks of a mesh.
class Ranks {
 public:
  explicit Ranks(const Layout& mesh) : network(mesh.ranks()) {
    for (int rank = 0; rank < mesh.ranks(); ++rank)
      all.push_back(std::make_unique<MeshTransport>(mesh, 2, network.transport(rank)));
  }
  /// Lets messages travel until none is on its way; returns those that came to rank 0.
  std::vector<Message> travel() {
    std::vector<Message> to_first;
    for (bool moved = true; moved; network.turn()) {
      moved = network.in_flight();
      for (const auto& rank : all)
        while (auto message = rank->receive())
          if (rank->rank() == 0) to_first.push_back(std::move(*message));
    }
    return to_first;
  }
  LoopbackNetwork network;
  std::vector<std::unique_ptr<MeshTransport>> all;
};

Message report_of(int gp) { return Message(make_header(Kind::report, {Role::gp, gp}, frame_buffer_id, 7)); }

}  // namespace

TEST_CASE("what nodes send goes from neighbour to neighbour, other messages straight to their rank") {
  const Layout mesh = mesh_layout(3, 1, 1);
  Ranks ranks(mesh);
  ranks.all[2]->send(0, report_of(2));
  // The rank between relays it, and has no message of its own.
  CHECK_FALSE(ranks.all[1]->receive());
  CHECK(ranks.all[1]->relayed());
  CHECK_FALSE(ranks.all[1]->relayed());
  CHECK(ranks.travel().size() == 1);
  CHECK(ranks.all[1]->relayed());  // its slot at rank 0 is free again
  ranks.all[2]->send(0, Message(make_header(Kind::stall, {Role::host, 2}, {Role::host, 0}, 0)));
  CHECK_FALSE(ranks.all[1]->receive());
  CHECK_FALSE(ranks.all[1]->relayed());
  CHECK(ranks.travel().size() == 1);
  for (const auto& rank : ranks.all) CHECK(rank->sends_done());
}

TEST_CASE("rank 0 collects what all links carried for a frame, by rank, once all have told") {
  const Layout mesh = mesh_layout(3, 1, 1);
  Ranks ranks(mesh);
  ranks.all[2]->send(0, report_of(2));
  ranks.all[1]->send(0, report_of(1));
  CHECK(ranks.travel().size() == 2);
  std::vector<LinkCounts> counts;
  ranks.all[0]->collect_counts(7, [&](std::vector<LinkCounts> all) { counts = std::move(all); });
  CHECK(counts.empty());
  CHECK_THAT(ranks.all[0]->waiting_for(),
             Contains("3 rank(s) have not yet reported their links for frame 7"));
  CHECK(ranks.travel().empty());
  REQUIRE(counts.size() == links(mesh).size());
  CHECK(total(counts).messages == 3);  // two hops and one
  for (std::size_t k = 1; k < counts.size(); ++k) CHECK(counts[k - 1].link.from <= counts[k].link.from);
  CHECK(ranks.all[0]->waiting_for().empty());
}

TEST_CASE("a report of links that nobody asked for is refused") {
  const Layout mesh = mesh_layout(2, 1, 1);
  Ranks ranks(mesh);
  std::vector<LinkCounts> counts;
  for (const Link& link : links_from(mesh, 1)) counts.push_back({.link = link});
  for (const NodeId from : {NodeId{Role::host, 1}, NodeId{Role::gp, 1}}) {
    ranks.network.transport(1).send(
        0, Message(make_header(Kind::link_report, from, {Role::host, 0}, 0), encode(counts)));
    CHECK_THROWS_WITH(ranks.all[0]->receive(), Contains("without being asked"));
  }
}
