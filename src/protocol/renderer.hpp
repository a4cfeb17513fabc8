#pragma once
#include <deque>
#include <map>
#include <optional>

#include "protocol/node.hpp"
#include "protocol/protocol_options.hpp"
#include "record/node_book.hpp"

namespace ringsplat {

/// Renderer (Neumann 1992, sections 2.3 and 3): draws payloads in the order of their sequence number, whoever
/// sent them and whenever they came, and delivers its tiles when the frame's last payload is drawn.
///
/// A payload is accepted when one of the frame's `slots` is free. The token's holder waits for that, so a
/// Renderer holds at most slots + 1 payloads of each announced frame.
class Renderer final : public Node {
 public:
  /// `engine` must outlive it.
  Renderer(int index, const Layout& layout, const ProtocolOptions& options, Engine& engine, Post post);

  NodeId id() const override { return {Role::renderer, index_}; }
  void begin_frame(const Announcement& announcement) override;
  void drop_frame(std::int64_t frame) override;
  void receive(Message message) override;
  bool advance() override;
  bool amid_slice() const override { return !frames_.empty() && frames_.front().painting; }
  bool idle() const override { return frames_.empty(); }
  std::string waiting_for() const override;

 private:
  struct Frame {
    Announcement announcement;
    std::map<std::uint32_t, Message> payloads;       ///< by sequence: not yet drawn, accepted or not
    std::uint32_t next = 0;                          ///< sequence of the payload to draw now
    std::optional<std::uint32_t> payloads_expected;  ///< known once the last GP has ended the frame
    Painter* painter = nullptr;                      ///< set only in the frame being drawn
    bool painting = false;                           ///< payload `next` is being drawn
    bool dropped = false;
    NodeStats stats;

    bool drawn() const { return payloads_expected && next == *payloads_expected; }
  };

  Frame& frame_of(const Header& header);
  void take_payload(Frame& frame, Message message);
  void take_end(Frame& frame, const Header& header);
  std::uint32_t slots_end(const Frame& frame) const;
  void accept(const Frame& frame, const Header& payload);
  void begin_drawing(Frame& frame);
  bool prepare(Frame& frame);
  bool draw_some(Frame& frame);
  void finish_payload(Frame& frame);
  void deliver(Frame& frame);
  void book(const Turn& turn);

  int index_;
  Layout layout_;
  ProtocolOptions options_;
  Engine& engine_;
  Post post_;
  NodeBook book_;
  std::deque<Frame> frames_;  ///< announced, not yet delivered; the first is being drawn
  EarlyMessages early_;
};

}  // namespace ringsplat
