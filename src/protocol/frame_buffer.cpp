#include <algorithm>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "base/byte_stream.hpp"
#include "base/clock.hpp"
#include "protocol/frame_source.hpp"
#include "protocol/node.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

/// The frame buffer announces frames and takes tiles. A frame is complete when every node has reported and
/// every tile that Renderers report has arrived; then it checks the conservation sums.
class FrameBuffer final : public Node {
 public:
  FrameBuffer(NodeParts parts, FrameSource& source) : my_(std::move(parts)), source_(source) {}

  NodeId id() const override { return frame_buffer_id; }
  void begin_frame(const Announcement&) override {}
  void drop_frame(std::int64_t) override {}
  void receive(Message message) override {
    const Header& h = message.header;
    if (h.kind == Kind::tile) return take_tile(frame_of(h), message);
    if (h.kind == Kind::report) return take_report(frame_of(h), message);
    refuse(id(), h);
  }

  bool advance() override {
    if (drop_unwanted()) return true;
    if (!frames_.empty() && frames_.front().complete()) {
      Frame frame = std::move(frames_.front());
      frames_.pop_front();
      complete(std::move(frame));
      return true;
    }
    const auto most = std::size_t(my_.options.frames_in_flight);
    if (!no_more_ && frames_.size() < most) return announce_next();
    if (no_more_ && frames_.empty() && !shut_down_) {
      shut_down_ = true;
      announce(Kind::shutdown, 0);
      return true;
    }
    return false;
  }
  bool idle() const override { return frames_.empty(); }
  std::string waiting_for() const override {
    if (frames_.empty()) return {};
    const Frame& f = frames_.front();
    std::vector<std::string> who;
    for (int n = 0; n < int(f.reported.size()); ++n) {
      if (f.reported[std::size_t(n)]) continue;
      const bool gp = n < my_.layout.gps;
      who.push_back(to_string({gp ? Role::gp : Role::renderer, gp ? n : n - my_.layout.gps}));
    }
    if (who.empty())
      return fmt::format("the frame buffer waits for {} tile(s) of frame {}", f.tiles_reported - f.tiles_here,
                         f.stats.frame);
    return fmt::format("the frame buffer waits for reports on frame {} from {}", f.stats.frame,
                       fmt::join(who, ", "));
  }

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

  void announce(Kind kind, std::int64_t frame, Bytes body = {}) {
    my_.post(Message(make_header(kind, id(), {Role::host, 0}, frame), std::move(body)));
  }

  bool drop_unwanted() {
    for (Frame& frame : frames_) {
      if (frame.stats.dropped || !source_.unwanted(frame.stats.frame)) continue;
      frame.stats.dropped = true;
      announce(Kind::drop, frame.stats.frame);
      return true;
    }
    return false;
  }

  bool announce_next() {
    auto body = source_.next(next_frame_);
    if (!body) {
      if (source_.may_come()) return false;
      no_more_ = true;
      return true;
    }
    const Announcement announcement{next_frame_++, std::move(*body)};
    frames_.push_back(make_frame(announcement));
    Bytes wire = Message::body_buffer();
    wire.insert(wire.end(), announcement.body.begin(), announcement.body.end());
    announce(Kind::announcement, announcement.frame, std::move(wire));
    return true;
  }

  Frame make_frame(const Announcement& announcement) {
    FramePlan plan = my_.engine.plan(announcement);
    Frame frame;
    frame.canvas = my_.engine.canvas(announcement);
    frame.tile_here.resize(plan.tiles.size());
    frame.tiles = std::move(plan.tiles);
    frame.reports_missing = my_.layout.gps + my_.layout.renderers;
    frame.reported.resize(std::size_t(frame.reports_missing));
    frame.announced = now_seconds();
    frame.stats.frame = announcement.frame;
    frame.stats.ascending = plan.ascending;
    frame.stats.slices = plan.slices();
    frame.stats.gps.resize(std::size_t(my_.layout.gps));
    frame.stats.renderers.resize(std::size_t(my_.layout.renderers));
    return frame;
  }

  Frame& frame_of(const Header& h) {
    for (auto& frame : frames_)
      if (frame.stats.frame == h.frame) return frame;
    throw RunError(fmt::format("the frame buffer got a {} of frame {} from {}, which is not being rendered",
                               name(h.kind), h.frame, to_string(h.from())));
  }

  void take_tile(Frame& frame, const Message& message) {
    const Header& h = message.header;
    const auto tile = std::size_t(fields_of<TileFields>(h).tile);  // a negative tile becomes too large
    if (tile >= frame.tiles.size() || h.from() != NodeId{Role::renderer, frame.tiles[tile].renderer} ||
        frame.tile_here[tile])
      throw RunError(fmt::format("{} delivered tile {} of frame {}, which is not its own or came before",
                                 to_string(h.from()), fields_of<TileFields>(h).tile, h.frame));
    if (message.body().size() != frame.tiles[tile].bytes)
      throw RunError(fmt::format("{} delivered {} bytes for tile {} of frame {}, which has {}",
                                 to_string(h.from()), h.bytes, tile, h.frame, frame.tiles[tile].bytes));
    frame.canvas->take(int(tile), message.body());
    frame.tile_here[tile] = true;
    ++frame.tiles_here;
  }

  void take_report(Frame& frame, const Message& message) {
    const Header& h = message.header;
    NodeStats stats;
    std::size_t at = 0;
    if (!take(message.body(), at, stats) || at != message.body().size())
      throw OtherBuild(fmt::format("{} sent a report of {} bytes", to_string(h.from()), h.bytes));
    const bool from_gp = h.source_role == Role::gp;
    if (!from_gp && h.source_role != Role::renderer)
      throw RunError(
          fmt::format("{} reported frame {}, in which it has no part", to_string(h.from()), h.frame));
    auto reported = frame.reported.begin() + (from_gp ? h.source : my_.layout.gps + h.source);
    if (*reported) throw RunError(fmt::format("{} reported frame {} twice", to_string(h.from()), h.frame));
    *reported = true;
    (from_gp ? frame.stats.gps : frame.stats.renderers)[std::size_t(h.source)] = stats;
    frame.tiles_reported += stats.tiles;
    --frame.reports_missing;
  }

  void complete(Frame&& frame) {
    FrameStats& stats = frame.stats;
    if (!stats.dropped) frame.canvas->finish();
    const double now = now_seconds();
    stats.seconds = now - frame.announced;
    stats.period = now - std::max(frame.announced, last_completed_);
    last_completed_ = now;
    if (my_.options.trace)
      my_.options.trace->of(id())->add(Activity::frame, stats.frame, -1, frame.announced, now);
    check_conservation(stats);
    source_.done(std::move(stats));
  }

  NodeParts my_;
  FrameSource& source_;
  std::deque<Frame> frames_;
  std::int64_t next_frame_ = 0;
  bool no_more_ = false, shut_down_ = false;
  double last_completed_ = 0;
};

}  // namespace

std::unique_ptr<Node> make_frame_buffer(NodeParts parts, FrameSource& source) {
  return std::make_unique<FrameBuffer>(std::move(parts), source);
}

}  // namespace ringsplat
