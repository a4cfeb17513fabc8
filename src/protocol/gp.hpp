#pragma once
#include <deque>
#include <memory>

#include "protocol/gp_frame.hpp"
#include "protocol/node.hpp"
#include "protocol/protocol_options.hpp"
#include "record/node_book.hpp"

namespace ringsplat {

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
