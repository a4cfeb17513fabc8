#pragma once
#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "net/transport.hpp"

namespace ringsplat {

struct Link;

/// What a test of a run puts between a rank's nodes and the network.
struct Between {
  /// Stands between links and nodes; empty: nothing does.
  std::function<std::unique_ptr<Transport>(Transport& links)> pace = {};
  std::function<void(const Link& link, const Header& header)> on_link_use = {};  ///< of a mesh's links
};

/// How messages travel between ranks that are all in one process; none of it changes a picture.
struct LoopbackOptions {
  std::uint64_t seed = 0;
  bool reorder = false;  ///< messages overtake each other
  int max_delay = 0;     ///< a message arrives up to that many turns late
  Between between = {};
  std::function<bool()> at_standstill = {};  ///< called when no rank can move: true when one can now
  std::function<void()> poll = {};           ///< called between turns; may throw to end the run
};

/// A network of ranks in one process. Tests of the protocol and runs without mpirun use it. It can delay and
/// reorder messages, repeatably by its seed.
class LoopbackNetwork {
 public:
  explicit LoopbackNetwork(int ranks, const LoopbackOptions& options = {})
      : options_(options), random_(options.seed), queues_(std::size_t(ranks)) {
    for (int r = 0; r < ranks; ++r) ends_.push_back(std::make_unique<End>(*this, r));
  }
  LoopbackNetwork(const LoopbackNetwork&) = delete;

  Transport& transport(int rank) { return *ends_.at(std::size_t(rank)); }
  /// Advances the clock that counts delays by one turn.
  void turn() { ++clock_; }
  /// True while there are messages that were sent and are not yet received.
  bool in_flight() const {
    return std::any_of(queues_.begin(), queues_.end(), [](const auto& q) { return !q.empty(); });
  }
  /// A repeatable random number below `bound`, for schedulers that shuffle.
  std::uint64_t random_below(std::uint64_t bound) {
    // Not std::uniform_int_distribution: its results differ between standard libraries.
    return bound == 0 ? 0 : random_() % bound;
  }

 private:
  struct InFlight {
    std::uint64_t due;
    Message message;
  };
  class End final : public Transport {
   public:
    End(LoopbackNetwork& network, int rank) : network_(network), rank_(rank) {}
    int rank() const override { return rank_; }
    int ranks() const override { return static_cast<int>(network_.queues_.size()); }

    void send(int destination, Message message) override {
      const auto delay = network_.random_below(std::uint64_t(network_.options_.max_delay) + 1);
      network_.queues_.at(std::size_t(destination)).push_back({network_.clock_ + delay, std::move(message)});
    }

    std::optional<Message> receive() override {
      auto& queue = network_.queues_[std::size_t(rank_)];
      if (queue.empty()) return std::nullopt;
      const auto start = network_.options_.reorder ? network_.random_below(queue.size()) : 0;
      for (std::size_t k = 0; k < queue.size(); ++k) {
        const auto at = (start + k) % queue.size();
        if (queue[at].due > network_.clock_) continue;
        Message message = std::move(queue[at].message);
        queue.erase(queue.begin() + static_cast<std::ptrdiff_t>(at));
        return message;
      }
      return std::nullopt;
    }

    bool sends_done() override { return true; }
    void wait_next() override {}

   private:
    LoopbackNetwork& network_;
    int rank_;
  };

  LoopbackOptions options_;
  std::mt19937_64 random_;
  std::uint64_t clock_ = 0;
  std::vector<std::deque<InFlight>> queues_;  ///< by receiver
  std::vector<std::unique_ptr<Transport>> ends_;
};

}  // namespace ringsplat
