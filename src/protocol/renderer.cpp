#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "protocol/node.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

/// Renderer (Neumann 1992, sections 2.3 and 3): draws payloads in the order of their sequence number, whoever
/// sent them and whenever they came, and delivers its tiles when the frame's last payload is drawn, or when
/// it has the layers of all others (FramePlan::shares).
///
/// A payload is accepted when one of the frame's `slots` is free. The token's holder waits for that, so a
/// Renderer holds at most slots + 1 payloads of each announced frame.
class Renderer final : public Node {
 public:
  explicit Renderer(NodeParts parts) : my_(std::move(parts)), book_(id(), my_.options.trace) {}

  NodeId id() const override { return {Role::renderer, my_.index}; }
  void begin_frame(const Announcement& announcement) override {
    frames_.emplace_back().announcement = announcement;
  }

  void drop_frame(std::int64_t number) override {
    for (auto& frame : frames_)
      if (frame.announcement.frame == number) frame.dropped = true;
  }

  void receive(Message message) override {
    const Header& h = message.header;
    Frame& frame = frame_of(h);
    if (h.kind == Kind::payload) return take_payload(frame, std::move(message));
    if (h.kind == Kind::pixels) return take_pixels(frame, std::move(message));
    if (h.kind != Kind::frame_end) refuse(id(), h);
    if (frame.payloads_expected)
      throw RunError(fmt::format("{} was told twice that frame {} is complete", to_string(id()), h.frame));
    frame.payloads_expected = fields_of<FrameEndFields>(h).payloads;
  }

  bool advance() override {
    book({});
    if (frames_.empty()) return false;
    Frame& frame = frames_.front();
    if (frame.painter == nullptr) {
      frame.painter = my_.engine.painter(my_.index, frame.announcement);
      begin(frame, my_.engine.plan(frame.announcement));
    }
    if (!frame.drawn()) return draw_some(frame) || prepare(frame);
    if (!frame.dropped && frame.painter->conclude())
      book({Activity::draw, frame.announcement.frame, -1});
    else if (!frame.takers.empty() && !std::exchange(frame.handed_over, true))
      hand_over(frame);
    else if (frame.gathered.size() < frame.givers.size())
      return false;
    else
      deliver(frame);
    return true;
  }
  bool amid_slice() const override { return !frames_.empty() && frames_.front().painting; }
  bool idle() const override { return frames_.empty(); }
  std::string waiting_for() const override {
    if (frames_.empty()) return {};
    const Frame& frame = frames_.front();
    const std::int64_t number = frame.announcement.frame;
    if (frame.payloads.contains(frame.next))
      return fmt::format("{} has payload {} of frame {} to draw", to_string(id()), frame.next, number);
    if (!frame.payloads_expected)
      return fmt::format("{} waits for payload {} of frame {} or for its end", to_string(id()), frame.next,
                         number);
    if (frame.drawn())
      return fmt::format("{} waits for the layers of {} Renderers of {} of frame {}", to_string(id()),
                         frame.givers.size() - frame.gathered.size(), frame.givers.size(), number);
    return fmt::format("{} waits for payload {} of {} of frame {}", to_string(id()), frame.next,
                       *frame.payloads_expected, number);
  }

 private:
  struct Frame {
    Announcement announcement;
    std::map<std::uint32_t, Message> payloads;       ///< by sequence: not yet drawn, accepted or not
    std::uint32_t next = 0;                          ///< sequence of the payload to draw now
    std::optional<std::uint32_t> payloads_expected;  ///< known once the last GP has ended the frame
    std::shared_ptr<Painter> painter;                ///< set only in the frame being drawn
    bool painting = false;                           ///< payload `next` is being drawn
    bool dropped = false;
    std::vector<int> takers;          ///< Renderers that get layers from here
    std::vector<int> givers;          ///< ascending: Renderers that send layers here
    std::map<int, Message> gathered;  ///< by Renderer: the layers that have come
    bool handed_over = false;
    NodeStats stats;

    bool drawn() const { return payloads_expected && next == *payloads_expected; }
  };

  Frame& frame_of(const Header& h) {
    for (auto& frame : frames_)
      if (frame.announcement.frame == h.frame) return frame;
    throw RunError(fmt::format("{} got a {} of frame {} from {} after that frame was delivered",
                               to_string(id()), name(h.kind), h.frame, to_string(h.from())));
  }

  void take_payload(Frame& frame, Message message) {
    const Header h = message.header;
    const TokenPlace place = fields_of<PayloadFields>(h).place;
    frame.stats.payload_bytes_received += h.bytes;
    book_.mark(Moment::take_payload, h.frame, place.step, place.renderer);
    if (place.sequence < frame.next || !frame.payloads.emplace(place.sequence, std::move(message)).second)
      throw RunError(fmt::format("{} got payload {} of frame {} twice, the second time from {}",
                                 to_string(id()), place.sequence, h.frame, to_string(h.from())));
    if (place.sequence > slots_end(frame))
      throw RunError(
          fmt::format("{} got payload {} of frame {} from {} while it had slots for those before {}",
                      to_string(id()), place.sequence, h.frame, to_string(h.from()), slots_end(frame)));
    if (place.sequence < slots_end(frame)) accept(frame, h);
  }

  void begin(Frame& frame, const FramePlan& plan) const {
    // A Renderer that draws nothing has no token.
    if (!plan.drawing(my_.layout.renderers)[std::size_t(my_.index)]) frame.payloads_expected = 0;
    if (plan.shares.empty()) return;
    frame.takers = plan.shares[std::size_t(my_.index)].takers;
    for (int r = 0; r < my_.layout.renderers; ++r)
      if (std::ranges::binary_search(plan.shares[std::size_t(r)].takers, my_.index))
        frame.givers.push_back(r);
  }

  void take_pixels(Frame& frame, Message message) {
    const Header h = message.header;
    if (!frame.gathered.emplace(h.source, std::move(message)).second)
      throw RunError(fmt::format("{} got layers of frame {} twice from {}", to_string(id()), h.frame,
                                 to_string(h.from())));
  }

  /// First sequence number without a slot. Slots go to payloads by number, not by arrival: those before an
  /// arrived one were all sent and need theirs. So only the payload of this number can be here without a
  /// slot.
  std::uint32_t slots_end(const Frame& frame) const { return frame.next + std::uint32_t(my_.options.slots); }

  void accept(const Frame& frame, const Header& payload) {
    const TokenPlace place = fields_of<PayloadFields>(payload).place;
    Bytes news;
    if (frame.painter != nullptr) frame.painter->news(payload.source, news);
    my_.post(Message(
        make_header(id(), payload.from(), payload.frame,
                    AcceptFields{.place = place, .free_slots = slots_end(frame) - 1 - place.sequence}),
        std::move(news)));
  }

  bool prepare(Frame& frame) {
    if (frame.dropped || !frame.painter->prepare()) return false;
    book({Activity::draw, frame.announcement.frame, -1});
    return true;
  }

  bool draw_some(Frame& frame) {
    const auto found = frame.payloads.find(frame.next);
    if (found == frame.payloads.end()) return false;
    const auto [place, passes] = fields_of<PayloadFields>(found->second.header);
    const PayloadToDraw payload{place.step, passes, found->second.body()};
    if (frame.dropped) {
      frame.painter->skip(payload);
      finish_payload(frame);
      return true;
    }
    if (!std::exchange(frame.painting, true)) frame.painter->begin(payload);
    const double composited = frame.painter->composite_seconds();
    const bool complete = frame.painter->work();
    book({.activity = Activity::draw,
          .frame = frame.announcement.frame,
          .step = place.step,
          .compositing = frame.painter->composite_seconds() - composited});
    if (complete) finish_payload(frame);
    return true;
  }

  void finish_payload(Frame& frame) {
    frame.painting = false;
    frame.payloads.erase(frame.next);
    ++frame.next;
    ++frame.stats.payloads_drawn;
    const auto waiting = frame.payloads.find(slots_end(frame) - 1);
    if (waiting != frame.payloads.end()) accept(frame, waiting->second.header);
  }

  /// Who takes layers waits for a message from each that may have some, also in a frame that is dropped.
  void hand_over(Frame& frame) {
    const std::int64_t number = frame.announcement.frame;
    for (const int taker : frame.takers) {
      Bytes bytes = frame.dropped ? Bytes{} : frame.painter->hand_over(taker);
      if (taker != my_.index) frame.stats.tile_bytes += Message::body_size(bytes);
      my_.post(Message(make_header(Kind::pixels, id(), {Role::renderer, taker}, number), std::move(bytes)));
    }
    book({Activity::deliver, number});
  }

  void deliver(Frame& frame) {
    NodeStats& stats = frame.stats;
    const std::int64_t number = frame.announcement.frame;
    for (const auto& [from, layers] : frame.gathered) {
      if (!std::ranges::binary_search(frame.givers, from))
        throw RunError(fmt::format("{} got layers of frame {} from Renderer {}, which has none for it",
                                   to_string(id()), number, from));
      if (!frame.dropped) frame.painter->gather(from, layers.body());
    }
    if (!frame.dropped)
      frame.painter->finish([&](int tile, Bytes bytes) {
        ++stats.tiles;
        stats.tile_bytes += Message::body_size(bytes);
        my_.post(
            Message(make_header(id(), frame_buffer_id, number, TileFields{.tile = tile}), std::move(bytes)));
      });
    book({Activity::deliver, number});
    const ItemCounts counts = frame.painter->counts();
    stats.splats_drawn = counts.drawn;
    stats.splats_clipped = counts.clipped;
    stats.splats_hidden = counts.hidden;
    stats.blocks = counts.blocks;
    stats.samples = counts.samples;
    my_.post(make_report(id(), number, stats));
    frames_.pop_front();
  }

  /// Books a turn on the frame being drawn.
  void book(const Turn& turn) { book_.turn(turn, frames_.empty() ? nullptr : &frames_.front().stats); }

  NodeParts my_;
  NodeBook book_;
  std::deque<Frame> frames_;  ///< announced, not yet delivered; the first is being drawn
};

}  // namespace

std::unique_ptr<Node> make_renderer(NodeParts parts) { return std::make_unique<Renderer>(std::move(parts)); }

}  // namespace ringsplat
