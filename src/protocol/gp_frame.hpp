#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "protocol/engine.hpp"
#include "ringsplat/net/message.hpp"

namespace ringsplat {

/// A token while a GP has it.
struct HeldToken {
  int renderer;
  std::uint32_t sequence;  ///< of the Renderer's next payload
  std::uint32_t credits;   ///< payloads that need not be accepted before it moves on
};

/// A slice whose payloads are made, until all its tokens have passed.
struct PreparedSlice {
  int step;
  std::vector<EncodedPart> parts;                ///< by Renderer; sent ones are empty
  int tokens_left;                               ///< that have not yet passed
  std::map<int, std::uint32_t> awaiting_accept;  ///< Renderer → sequence of the payload sent to it
};

/// A GP's part of one frame.
struct GpFrame {
  GpFrame(int gp, const Announcement& announcement, int renderers, Engine& engine);

  std::int64_t number;
  FramePlan plan;
  std::vector<bool> drawing;  ///< by Renderer: it has tiles, and a token
  int tokens = 0;             ///< one for each of these
  std::unique_ptr<Encoder> encoder;
  std::vector<int> shown;     ///< steps that tokens go through, ascending
  std::vector<int> steps;     ///< of these, this GP's
  std::size_t next_step = 0;  ///< into `steps`: the next to encode
  bool encoding = false;      ///< it is being encoded
  std::deque<PreparedSlice> prepared;
  std::map<int, std::vector<HeldToken>> waiting_tokens;  ///< by step: came before the slice was ready
  std::set<std::pair<int, std::uint32_t>> left_behind;   ///< Renderer and sequence of payloads whose tokens
                                                         ///< moved on before they were accepted
  std::size_t steps_done = 0;
  bool dropped = false;  ///< slices not yet sent are left out
  NodeStats stats;

  bool owns_front() const { return !steps.empty() && steps.front() == shown.front(); }
  bool owns(int step) const;
  /// The next of the shown steps, or none.
  std::optional<int> after(int step) const;
  PreparedSlice* find_slice(int step);
  bool done() const { return steps_done == steps.size() && left_behind.empty(); }
  /// Counts the slices at the front whose tokens have all passed.
  void retire_slices();
  /// What it waits for, in words; empty when for nothing.
  std::string waiting_for(const std::string& gp) const;

 private:
  int owner_before(int step) const;
};

}  // namespace ringsplat
