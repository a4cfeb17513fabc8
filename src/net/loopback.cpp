#include "net/loopback.hpp"

#include <algorithm>
#include <deque>
#include <random>
#include <vector>

namespace ringsplat {
namespace {

struct InFlight {
  std::uint64_t due;
  Message message;
};

}  // namespace

struct LoopbackNetwork::State {
  class End;
  LoopbackOptions options;
  std::mt19937_64 random;
  std::uint64_t clock = 0;
  std::vector<std::deque<InFlight>> queues;
  std::vector<std::unique_ptr<End>> ends;

  // Not std::uniform_int_distribution: its results differ between standard libraries.
  std::uint64_t below(std::uint64_t bound) { return bound == 0 ? 0 : random() % bound; }
};

class LoopbackNetwork::State::End final : public Transport {
 public:
  End(State& state, int rank) : state_(state), rank_(rank) {}
  int rank() const override { return rank_; }
  int ranks() const override { return static_cast<int>(state_.queues.size()); }

  void send(int destination, Message message) override {
    const auto delay = state_.below(std::uint64_t(state_.options.max_delay) + 1);
    state_.queues.at(std::size_t(destination)).push_back({state_.clock + delay, std::move(message)});
  }

  std::optional<Message> receive() override {
    auto& queue = state_.queues[std::size_t(rank_)];
    if (queue.empty()) return std::nullopt;
    const auto start = state_.options.reorder ? state_.below(queue.size()) : 0;
    for (std::size_t k = 0; k < queue.size(); ++k) {
      const auto at = (start + k) % queue.size();
      if (queue[at].due > state_.clock) continue;
      Message message = std::move(queue[at].message);
      queue.erase(queue.begin() + static_cast<std::ptrdiff_t>(at));
      return message;
    }
    return std::nullopt;
  }

  bool sends_done() override { return true; }
  void wait_next() override {}

 private:
  State& state_;
  int rank_;
};

LoopbackNetwork::LoopbackNetwork(int ranks, const LoopbackOptions& options)
    : state_(std::make_unique<State>()) {
  state_->options = options;
  state_->random.seed(options.seed);
  state_->queues.resize(std::size_t(ranks));
  for (int r = 0; r < ranks; ++r) state_->ends.push_back(std::make_unique<State::End>(*state_, r));
}

LoopbackNetwork::~LoopbackNetwork() = default;

Transport& LoopbackNetwork::transport(int rank) { return *state_->ends.at(std::size_t(rank)); }
void LoopbackNetwork::turn() { ++state_->clock; }
bool LoopbackNetwork::in_flight() const {
  return std::any_of(state_->queues.begin(), state_->queues.end(), [](const auto& q) { return !q.empty(); });
}
std::uint64_t LoopbackNetwork::random_below(std::uint64_t bound) { return state_->below(bound); }

}  // namespace ringsplat
