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
  int stopping_rank = -1;  ///< fault injection: this rank takes no turn any more …
  int stops_at_turn = 0;   ///< … from this one on
};

/// All ranks in one process: a network that can delay and reorder messages, repeatably by its
/// seed, which is how the protocol is tested and how the program runs without mpirun.
class LoopbackNetwork {
 public:
  explicit LoopbackNetwork(int ranks, const LoopbackOptions& options = {});
  ~LoopbackNetwork();
  LoopbackNetwork(const LoopbackNetwork&) = delete;
  LoopbackNetwork& operator=(const LoopbackNetwork&) = delete;

  Transport& transport(int rank);
  /// One turn of the clock by which delays are counted.
  void turn();
  bool in_flight() const;  ///< messages sent and not yet received
  /// A repeatable number below `bound`, for schedulers that shuffle.
  std::uint64_t random_below(std::uint64_t bound);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ringsplat
