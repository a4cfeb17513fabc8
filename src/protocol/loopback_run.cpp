#include "protocol/loopback_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <numeric>

#include "net/lock_step.hpp"
#include "protocol/rank.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

std::string who_waits(const std::vector<std::unique_ptr<Rank>>& ranks, int stopped_rank) {
  std::string who;
  for (const auto& rank : ranks) {
    const Host& host = rank->host();
    const std::string what = host.waiting_for();
    who += fmt::format("\n  rank {}{}: {}", host.rank(), host.rank() == stopped_rank ? " (stopped)" : "",
                       what.empty() ? "the next frame" : what);
  }
  return who;
}

}  // namespace

void run_loopback(const Layout& layout, const ProtocolOptions& options,
                  const std::function<std::unique_ptr<Engine>(int rank)>& make_engine, FrameSource& source,
                  const LoopbackOptions& loopback) {
  ProtocolOptions protocol = options;
  if (loopback.in_step) protocol.frames_in_flight = 1;
  const auto clock = std::make_shared<LockStep>();
  Between in_step;
  if (loopback.in_step) {
    in_step.pace = [clock](Transport& links) { return std::make_unique<LockStepTransport>(links, clock); };
    if (loopback.on_link_use)
      in_step.observer = [&](const Link& link, const Header& h) {
        loopback.on_link_use(clock->now(), link, h);
      };
  }
  LoopbackNetwork network(layout.ranks(), loopback);
  std::vector<std::unique_ptr<Engine>> engines;
  std::vector<std::unique_ptr<Rank>> ranks;
  for (int rank = 0; rank < layout.ranks(); ++rank) {
    engines.push_back(make_engine(rank));
    ranks.push_back(std::make_unique<Rank>(layout, protocol, network.transport(rank), *engines.back(),
                                           rank == 0 ? &source : nullptr, in_step));
  }
  std::vector<std::size_t> order(ranks.size());
  std::iota(order.begin(), order.end(), 0);
  int quiet_turns = 0, pauses = 0;
  for (std::int64_t turn = 0;
       !std::all_of(ranks.begin(), ranks.end(), [](const auto& r) { return r->host().finished(); }); ++turn) {
    if (loopback.poll) loopback.poll();
    // Asked before the ranks are: another thread may end the source while they look for its next frame.
    const bool more_may_come = source.may_come();
    if (loopback.reorder)
      for (std::size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[network.random_below(k)]);
    const int stopped_rank = turn >= loopback.stops_at_turn ? loopback.stopping_rank : -1;
    bool moved = false;
    for (const auto rank : order)
      if (int(rank) != stopped_rank) moved = ranks[rank]->host().step() || moved;
    network.turn();
    quiet_turns = moved ? 0 : quiet_turns + 1;
    if (moved) pauses = 0;
    // A delayed message arrives within max_delay turns.
    if (quiet_turns <= loopback.max_delay && (moved || network.in_flight())) continue;
    if (clock->kept == 0 && more_may_come) {
      constexpr auto shortest = std::chrono::microseconds(200), longest = std::chrono::microseconds(10000);
      source.pause(std::min(longest, shortest * (1 + pauses++ / 16)));
      continue;
    }
    if (clock->kept == 0)
      throw RunError("no rank can move and no message on its way can change that:" +
                     who_waits(ranks, stopped_rank));
    clock->advance();
    quiet_turns = 0;
  }
}

}  // namespace ringsplat
