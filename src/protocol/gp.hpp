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
#include "protocol/node.hpp"
#include "protocol/protocol_options.hpp"
#include "record/node_book.hpp"

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

/// Graphics Processor (Neumann 1992, section 3): prepares its slices of a traversal in order, sends a slice's
/// payload to a Renderer when that Renderer's token for the slice is here, and passes the token on once the
/// payload is accepted, or, beyond the paper, at once while the token knows of free slots (`send_ahead`).
///
/// Memory is bounded: at most `look_ahead` slices are prepared at once, and at most slots + 1 payloads are on
/// their way to a Renderer.
class Gp final : public Node {
 public:
  /// `engine` must outlive it.
  Gp(int index, const Layout& layout, const ProtocolOptions& options, Engine& engine, Post post);

  NodeId id() const override { return {Role::gp, index_}; }
  void begin_frame(const Announcement& announcement) override;
  void drop_frame(std::int64_t frame) override;
  void receive(Message message) override;
  bool advance() override;
  bool amid_slice() const override;
  bool idle() const override { return frames_.empty(); }
  std::string waiting_for() const override;

 private:
  using Frame = GpFrame;

  void start_tokens(Frame& frame);
  std::uint32_t credits_of(std::uint32_t free_slots) const;
  Frame* find_frame(std::int64_t frame);
  void take_token(Frame& frame, const Header& header);
  void take_accept(Frame& frame, const Header& header);
  void use_token(Frame& frame, PreparedSlice& slice, HeldToken token);
  void pass_token(Frame& frame, PreparedSlice& slice, HeldToken token);
  Turn encode_some();
  void prepare_slice(Frame& frame, EncodedStep&& encoded);
  void finish_completed_frames();
  void report(Frame& frame);
  std::size_t prepared_slices() const;
  Turn waiting() const;
  void book(const Turn& turn);

  int index_;
  Layout layout_;
  ProtocolOptions options_;
  Engine& engine_;
  Post post_;
  NodeBook book_;
  std::deque<std::unique_ptr<Frame>> frames_;  ///< announced frames whose part here is not over
  EarlyMessages early_;
};

}  // namespace ringsplat
