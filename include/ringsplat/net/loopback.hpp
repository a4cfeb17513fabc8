#pragma once
#include <cstdint>
#include <memory>

#include "ringsplat/net/mesh_lock_step.hpp"
#include "ringsplat/net/transport.hpp"

namespace ringsplat {

struct LoopbackOptions {
  std::uint64_t seed = 0;
  bool reorder = false;  ///< messages overtake each other
  int max_delay = 0;     ///< a message arrives up to that many turns late
  bool in_step = false;  ///< one frame at a time, and all tokens move one GP per step of a common clock
                         ///< (mesh_lock_step.hpp)
  /// In step: called with every mesh link in use.
  LockStep::Observer on_link_use = {};
  int stopping_rank = -1;  ///< fault injection: this rank takes no more turns …
  int stops_at_turn = 0;   ///< … from this one on
};

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
