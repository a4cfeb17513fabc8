#pragma once
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "ringsplat/base/image.hpp"
#include "ringsplat/node/node.hpp"
#include "ringsplat/node/stats.hpp"
#include "ringsplat/splat/encode.hpp"

namespace ringsplat {

struct FrameResult {
  FrameSpec spec;
  Image image;
  FrameStats stats;
};

/// Where frames come from and go to; lives on rank 0.
struct Director {
  /// The next frame to render, or nothing when there are no more. `frame` is set by the frame buffer: 0, 1,
  /// 2 …
  std::function<std::optional<FrameSpec>()> next_frame;
  std::function<void(FrameResult&&)> frame_done;
  /// For views that come while others are rendered; may be left empty. True while next_frame has nothing now
  /// and may have something later.
  std::function<bool()> may_come = {};
  /// True when an announced frame is not wanted any more: it is dropped, and not handed to frame_done.
  std::function<bool(const FrameSpec&)> unwanted = {};
};

/// Frame buffer: announces frames, assembles tiles, and knows by counting when a frame is complete: every
/// node has reported and every tile the Renderers report is here. Checks the conservation sums at each
/// frame's end. In a mesh with manhattan routing it then asks every rank what its links carried for the
/// frame: only now has all of it arrived.
class FrameBuffer final : public Node {
 public:
  /// `announce` carries a frame_spec or shutdown message to every rank, this one included.
  FrameBuffer(const Layout& layout, const ProtocolOptions& options, const Grid& grid, Director director,
              Post announce);

  NodeId id() const override { return frame_buffer_id; }
  void begin_frame(const FrameSpec&) override {}
  void drop_frame(std::int64_t) override {}
  void receive(Message message) override;
  bool advance() override;
  std::string waiting_for() const override;

 private:
  /// A complete frame whose link counts are on their way.
  struct Settling {
    FrameResult result;
    std::vector<std::vector<LinkCounts>> links;  ///< by rank
    std::vector<bool> reported;
    int reports_missing = 0;
  };
  struct Frame {
    FrameSpec spec;
    FrameGeometry geometry;
    Image image;         ///< of the image plane
    PixelWindow filled;  ///< part of it that tiles have filled
    std::optional<RegionOwners> owners;
    std::vector<bool> tile_here;
    std::vector<bool> gp_reported, renderer_reported;
    int reports_missing = 0;
    std::uint64_t tiles_here = 0, tiles_reported = 0;
    double announced = 0;
    FrameStats stats;
    bool complete() const { return reports_missing == 0 && tiles_here == tiles_reported; }
  };

  bool drop_unwanted();
  bool announce_next();
  Frame& frame_of(const Header& header);
  void take_tile(Frame& frame, const Message& message);
  void take_report(Frame& frame, const Message& message);
  void take_link_report(const Message& message);
  static void clear_where_no_tile_came(Frame& frame);
  void complete(Frame&& frame);
  void hand_over(Settling&& settled);

  Layout layout_;
  ProtocolOptions options_;
  Grid grid_;
  Director director_;
  Post announce_;
  std::deque<Frame> frames_;
  std::deque<Settling> settling_;
  std::int64_t next_frame_ = 0;
  double last_completed_ = 0;  ///< when the last frame was
  bool no_more_ = false, shut_down_ = false;
};

}  // namespace ringsplat
