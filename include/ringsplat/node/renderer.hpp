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

/// Renderer (Neumann 1992, sections 2.3 and 3): draws payloads in the order of their sequence number, whoever
/// sent them and whenever they came, and delivers its tiles when the frame's last payload is drawn.
///
/// A payload is accepted when one of the frame's `slots` is free; the token holder waits for that, so at most
/// slots + 1 payloads of each announced frame are ever here.
class Renderer final : public Node {
 public:
  Renderer(int index, const Layout& layout, const ProtocolOptions& options, const Grid& grid, Post post);

  NodeId id() const override { return {Role::renderer, index_}; }
  void begin_frame(const FrameSpec& spec) override;
  void drop_frame(std::int64_t frame) override;
  void receive(Message message) override;
  bool advance() override;
  bool amid_slice() const override { return !frames_.empty() && frames_.front().painting; }
  std::string waiting_for() const override;

 private:
  struct Frame {
    FrameSpec spec;
    std::map<std::uint32_t, Message> payloads;       ///< by sequence, accepted or not, not yet drawn
    std::uint32_t next = 0;                          ///< sequence of the payload to draw now
    std::optional<std::uint32_t> payloads_expected;  ///< known once the last GP has ended the frame
    bool painting = false;                           ///< payload `next` is being drawn
    bool painted = false;                            ///< it is drawn, while the simulated time for it passes
    std::uint64_t splats_before = 0;                 ///< drawn or clipped before this payload
    bool begun = false;
    bool dropped = false;
    NodeStats stats;

    bool drawn() const { return payloads_expected && next == *payloads_expected; }
  };

  Frame& frame_of(const Header& header);
  void take_payload(Frame& frame, Message message);
  std::uint32_t slots_end(const Frame& frame) const;
  void accept(const Frame& frame, Header payload);
  bool draw_some(Frame& frame);
  void finish_payload(Frame& frame);
  void deliver(Frame& frame);
  std::uint64_t painted_splats() const;
  void owe_drawing(const Header& payload, std::uint64_t splats);
  void account_time(double NodeStats::*part);

  int index_;
  Layout layout_;
  ProtocolOptions options_;
  Grid grid_;
  Post post_;
  ThreadTeam threads_;
  std::unique_ptr<Painter> painter_;
  std::deque<Frame> frames_;  ///< announced and not yet delivered; the first is being drawn
  std::int64_t next_frame_ = 0;
  std::vector<Message> early_;
  Debt debt_;  ///< simulated seconds of drawing that have not yet passed
  double last_time_;
  NodeTrace* trace_;  ///< null: not recorded
};

}  // namespace ringsplat
