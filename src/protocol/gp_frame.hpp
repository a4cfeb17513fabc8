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

#include "net/message.hpp"
#include "protocol/engine.hpp"

namespace ringsplat {

/// A token while a GP has it.
struct HeldToken {
  int renderer;
  std::uint32_t sequence;  ///< number of the Renderer's next payload
  std::uint32_t credits;   ///< payloads it may leave unaccepted when it moves on
};

/// A slice from the time its payloads are made until all its tokens have passed.
struct PreparedSlice {
  int step;
  std::vector<EncodedPart> parts;                ///< by Renderer; sent ones are empty
  int tokens_left;                               ///< tokens that have not yet passed
  std::map<int, std::uint32_t> awaiting_accept;  ///< Renderer → sequence of the payload sent to it
};

/// A GP's part of one frame.
struct GpFrame {
  GpFrame(int gp, const Announcement& announcement, int renderers, Engine& engine);

  std::int64_t number;
  FramePlan plan;
  std::vector<bool> drawing;  ///< by Renderer: it has tiles, and a token
  int tokens = 0;             ///< Renderers with a token
  std::unique_ptr<Encoder> encoder;
  std::vector<int> shown;     ///< steps that tokens go through, ascending
  std::vector<int> steps;     ///< those of `shown` that this GP owns
  std::size_t next_step = 0;  ///< index into `steps` of the next to encode
  bool encoding = false;      ///< steps[next_step] is being encoded
  std::deque<PreparedSlice> prepared;
  /// By step: tokens that came before the slice was ready.
  std::map<int, std::vector<HeldToken>> waiting_tokens;
  /// Renderer and sequence of payloads that their tokens left behind unaccepted.
  std::set<std::pair<int, std::uint32_t>> left_behind;
  std::size_t steps_done = 0;
  bool dropped = false;  ///< slices not yet sent are skipped
  NodeStats stats;

  bool owns_front() const { return !steps.empty() && steps.front() == shown.front(); }
  bool owns(int step) const;
  /// The shown step after `step`, if any.
  std::optional<int> after(int step) const;
  PreparedSlice* find_slice(int step);
  bool done() const { return steps_done == steps.size() && left_behind.empty(); }
  /// Removes slices from the front whose tokens have all passed, and counts them as done.
  void retire_slices();
  /// What it waits for, in words; empty when for nothing.
  std::string waiting_for(const std::string& gp) const;

 private:
  int owner_before(int step) const;
};

}  // namespace ringsplat
