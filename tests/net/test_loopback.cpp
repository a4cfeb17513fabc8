#include <algorithm>
#include <set>
#include <vector>

#include "net/loopback.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

/// The order in which 50 messages from rank 0 reach rank 1.
std::vector<std::uint32_t> arrivals(const LoopbackOptions& options) {
  LoopbackNetwork network(2, options);
  for (std::uint32_t k = 0; k < 50; ++k)
    network.transport(0).send(
        1, Message(make_header({Role::gp, 0}, {Role::gp, 1}, 0, TokenFields{.place = {.sequence = k}})));
  std::vector<std::uint32_t> order;
  while (network.in_flight()) {
    while (auto message = network.transport(1).receive())
      order.push_back(token_place(message->header)->sequence);
    network.turn();
  }
  return order;
}

}  // namespace

TEST_CASE("without options messages arrive at once and in order") {
  const auto order = arrivals({});
  REQUIRE(order.size() == 50);
  CHECK(std::is_sorted(order.begin(), order.end()));
}

TEST_CASE("delay and reordering lose nothing, are repeatable by seed and do reorder") {
  const LoopbackOptions options{.seed = 3, .reorder = true, .max_delay = 5};
  const auto order = arrivals(options);
  CHECK(std::set<std::uint32_t>(order.begin(), order.end()).size() == 50);
  CHECK_FALSE(std::is_sorted(order.begin(), order.end()));
  CHECK(order == arrivals(options));
  CHECK(order != arrivals({.seed = 4, .reorder = true, .max_delay = 5}));
}
