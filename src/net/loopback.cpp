#include "net/loopback.hpp"

#include <algorithm>

namespace ringsplat {

class LoopbackNetwork::End final : public Transport {
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

LoopbackNetwork::LoopbackNetwork(int ranks, const LoopbackOptions& options)
    : options_(options), random_(options.seed), queues_(std::size_t(ranks)) {
  for (int r = 0; r < ranks; ++r) ends_.push_back(std::make_unique<End>(*this, r));
}

bool LoopbackNetwork::in_flight() const {
  return std::any_of(queues_.begin(), queues_.end(), [](const auto& q) { return !q.empty(); });
}

}  // namespace ringsplat
