#include <functional>
#include <set>

#include "net/message.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

TEST_CASE("every node lives on exactly one rank, and that rank knows it") {
  for (const auto placement : {Placement::dedicated, Placement::colocated})
    for (const int gps : {1, 2, 3, 7, 24, 509})
      for (const int renderers : {1, 2, 5, 16}) {
        const Layout layout{gps, renderers, placement};
        int hosted = 0;
        for (int rank = 0; rank < layout.ranks(); ++rank)
          for (const NodeId node : layout.nodes_on(rank)) {
            REQUIRE(layout.rank_of(node) == rank);
            ++hosted;
          }
        REQUIRE(hosted == gps + renderers + 1);
      }
}

TEST_CASE("idle ranks are behind all others and host nothing") {
  for (const auto placement : {Placement::dedicated, Placement::colocated}) {
    const Layout all{.gps = 3, .renderers = 2, .placement = placement};
    Layout some = all;
    some.idle = 4;
    CHECK(some.working_ranks() == all.ranks());
    CHECK(some.ranks() == all.ranks() + 4);
    for (int rank = 0; rank < some.ranks(); ++rank) CHECK(some.nodes_on(rank) == all.nodes_on(rank));
    CHECK(some.nodes_on(all.ranks()).empty());
    CHECK_NOTHROW(check(some));
    some.idle = -1;
    CHECK_THROWS_AS(check(some), InputError);
  }
  Layout mesh = mesh_layout(2, 2, 2);
  mesh.idle = 1;
  CHECK_THROWS_AS(check(mesh), InputError);
}

TEST_CASE("an announcement reaches every rank exactly once") {
  for (const int ranks : {1, 2, 3, 4, 5, 8, 13, 64, 509, 1024}) {
    std::multiset<int> reached{0};
    int deepest = 0;
    const std::function<void(int, int)> visit = [&](int rank, int depth) {
      deepest = std::max(deepest, depth);
      for (const int child : announcement_children(rank, ranks)) {
        reached.insert(child);
        visit(child, depth + 1);
      }
    };
    visit(0, 0);
    REQUIRE(reached.size() == std::size_t(ranks));
    REQUIRE(std::set<int>(reached.begin(), reached.end()).size() == std::size_t(ranks));
    REQUIRE((1 << deepest) <= std::max(1, ranks));
  }
}

TEST_CASE("layouts without nodes are refused") {
  CHECK_THROWS_AS(check(Layout{0, 1}), InputError);
  CHECK_THROWS_AS(check(Layout{1, 0}), InputError);
  CHECK_NOTHROW(check(Layout{1, 1}));
}
