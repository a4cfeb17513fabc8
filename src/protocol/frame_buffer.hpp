#pragma once
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "protocol/frame_source.hpp"
#include "protocol/node.hpp"
#include "protocol/protocol_options.hpp"

namespace ringsplat {

/// The frame buffer announces frames and takes tiles. A frame is complete when every node has reported and
/// every tile that Renderers report has arrived; then it checks the conservation sums.
class FrameBuffer final : public Node {
 public:
  /// `engine` and `source` must outlive it. `announce` carries an announcement, a drop or a shutdown to every
  /// rank, this one included.
  FrameBuffer(const Layout& layout, const ProtocolOptions& options, Engine& engine, FrameSource& source,
              Post announce);

  NodeId id() const override { return frame_buffer_id; }
  void begin_frame(const Announcement&) override {}
  void drop_frame(std::int64_t) override {}
  void receive(Message message) override;
  bool advance() override;
  bool idle() const override { return frames_.empty(); }
  std::string waiting_for() const override;

 private:
  struct Frame {
    std::vector<FramePlan::Tile> tiles;
    std::unique_ptr<Canvas> canvas;
    std::vector<bool> tile_here;
    std::vector<bool> reported;  ///< by GP, then by Renderer
    int reports_missing = 0;
    std::uint64_t tiles_here = 0, tiles_reported = 0;
    double announced = 0;
    FrameStats stats;
    bool complete() const { return reports_missing == 0 && tiles_here == tiles_reported; }
  };

  bool drop_unwanted();
  bool announce_next();
  Frame make_frame(const Announcement& announcement);
  Frame& frame_of(const Header& header);
  void take_tile(Frame& frame, const Message& message);
  void take_report(Frame& frame, const Message& message);
  void complete(Frame&& frame);
  void announce(Kind kind, std::int64_t frame, Bytes body = {});

  Layout layout_;
  ProtocolOptions options_;
  Engine& engine_;
  FrameSource& source_;
  Post announce_;
  std::deque<Frame> frames_;
  std::int64_t next_frame_ = 0;
  bool no_more_ = false, shut_down_ = false;
  double last_completed_ = 0;
};

}  // namespace ringsplat
