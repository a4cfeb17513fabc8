#pragma once
#include <cstdint>
#include <memory>

#include "net/loopback_options.hpp"
#include "net/transport.hpp"

namespace ringsplat {

/// A network of ranks in one process. Tests of the protocol and runs without mpirun use it. It can delay and
/// reorder messages, repeatably by its seed.
class LoopbackNetwork {
 public:
  explicit LoopbackNetwork(int ranks, const LoopbackOptions& options = {});
  ~LoopbackNetwork();
  LoopbackNetwork(const LoopbackNetwork&) = delete;
  LoopbackNetwork& operator=(const LoopbackNetwork&) = delete;

  Transport& transport(int rank);
  /// Advances the clock that counts delays by one turn.
  void turn();
  bool in_flight() const;  ///< messages sent and not yet received
  /// A repeatable random number below `bound`, for schedulers that shuffle.
  std::uint64_t random_below(std::uint64_t bound);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ringsplat
