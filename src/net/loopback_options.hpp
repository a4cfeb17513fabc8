#pragma once
#include <cstdint>
#include <functional>

namespace ringsplat {

struct Header;
struct Link;

/// How messages travel between ranks that are all in one process; none of it changes a picture.
struct LoopbackOptions {
  std::uint64_t seed = 0;
  bool reorder = false;  ///< messages overtake each other
  int max_delay = 0;     ///< a message arrives up to that many turns late
  bool in_step = false;  ///< one frame at a time, and all tokens move one GP per step of a common clock
                         ///< (mesh_lock_step.hpp)
  /// In step: called with every mesh link in use.
  std::function<void(std::int64_t step, const Link& link, const Header& header)> on_link_use = {};
  int stopping_rank = -1;  ///< fault injection: this rank takes no more turns …
  int stops_at_turn = 0;   ///< … from this one on
  std::function<void()> poll = {};  ///< called between turns; may throw to end the run
};

}  // namespace ringsplat
