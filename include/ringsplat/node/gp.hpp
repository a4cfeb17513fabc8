#pragma once
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "ringsplat/model/charge.hpp"
#include "ringsplat/node/engine.hpp"
#include "ringsplat/node/node.hpp"
#include "ringsplat/node/stats.hpp"

namespace ringsplat {

/// Graphics Processor (Neumann 1992, section 3): prepares its slices of a traversal in order, sends a slice's
/// payload to a Renderer when that Renderer's token for the slice is here, and passes the token on once the
/// payload is accepted, or, beyond the paper, at once while the token knows of free slots (`send_ahead`).
///
/// At most `look_ahead` slices are prepared at once, and no more payloads are on their way to a Renderer than
/// it has slots, but for one, so memory is bounded.
class Gp final : public Node {
 public:
  Gp(int index, const Layout& layout, const ProtocolOptions& options, SliceStore slices, Post post);
  ~Gp() override;

  NodeId id() const override { return {Role::gp, index_}; }
  void begin_frame(const FrameSpec& spec) override;
  void drop_frame(std::int64_t frame) override;
  void receive(Message message) override;
  bool advance() override;
  bool amid_slice() const override;
  std::string waiting_for() const override;

 private:
  struct Frame;
  struct PreparedSlice;
  struct HeldToken {
    int renderer;
    std::uint32_t sequence;
    std::uint32_t credits;  ///< payloads that need not be accepted before it moves on
  };

  std::uint32_t credits_of(std::uint32_t free_slots) const;
  EmptySpace& empty_space_of(int level);
  void find_steps(Frame& frame);
  Frame* find_frame(std::int64_t frame);
  bool encode_some();
  void use_waiting_tokens(Frame& frame, PreparedSlice& slice);
  void use_token(Frame& frame, PreparedSlice& slice, HeldToken token);
  void pass_token(Frame& frame, PreparedSlice& slice, HeldToken token);
  void take_token(Frame& frame, const Header& header);
  void take_accept(Frame& frame, const Header& header);
  void finish_completed_frames();
  void account_time(bool computed);
  void trace_time(double begin, double end, bool computed);
  std::size_t prepared_slices() const;

  int index_;
  Layout layout_;
  ProtocolOptions options_;
  SliceStore slices_;
  Post post_;
  std::map<int, std::unique_ptr<EmptySpace>> empty_space_;  ///< by level
  ThreadTeam threads_;
  std::deque<std::unique_ptr<Frame>> frames_;
  std::int64_t next_frame_ = 0;
  std::vector<Message> early_;  ///< of frames not yet announced here
  Debt debt_;                   ///< simulated seconds of encoding that have not yet passed
  double last_time_;
  NodeTrace* trace_;  ///< null: not recorded
  struct {
    std::int64_t frame = 0;
    int step = 0;
    StageSeconds stages;
  } piece_;  ///< the slice worked on, and the last piece's seconds; kept up only when recorded
};

}  // namespace ringsplat
