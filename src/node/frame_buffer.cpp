#include "ringsplat/node/frame_buffer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "ringsplat/base/clock.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/node/trace.hpp"
#include "ringsplat/splat/warp_image.hpp"

namespace ringsplat {

FrameBuffer::FrameBuffer(const Layout& layout, const ProtocolOptions& options, const Grid& grid,
                         Director director, Post announce)
    : layout_(layout),
      options_(options),
      grid_(grid),
      director_(std::move(director)),
      announce_(std::move(announce)) {}

bool FrameBuffer::advance() {
  if (drop_unwanted()) return true;
  if (!frames_.empty() && frames_.front().complete()) {
    Frame frame = std::move(frames_.front());
    frames_.pop_front();
    complete(std::move(frame));
    return true;
  }
  if (!settling_.empty() && settling_.front().reports_missing == 0) {
    Settling settled = std::move(settling_.front());
    settling_.pop_front();
    hand_over(std::move(settled));
    return true;
  }
  const auto most = std::size_t(options_.frames_in_flight);
  // One frame more may wait for its link counts, so that asking for them does not hold up the next.
  if (!no_more_ && frames_.size() < most && frames_.size() + settling_.size() <= most) return announce_next();
  if (no_more_ && frames_.empty() && settling_.empty() && !shut_down_) {
    shut_down_ = true;
    announce_(Message({.kind = Kind::shutdown, .source_role = Role::frame_buffer}));
    return true;
  }
  return false;
}

bool FrameBuffer::drop_unwanted() {
  if (!director_.unwanted) return false;
  for (Frame& frame : frames_) {
    if (frame.stats.dropped || !director_.unwanted(frame.spec)) continue;
    frame.stats.dropped = true;
    announce_(Message({.kind = Kind::drop, .source_role = Role::frame_buffer, .frame = frame.spec.frame}));
    return true;
  }
  return false;
}

bool FrameBuffer::announce_next() {
  auto spec = director_.next_frame();
  if (!spec) {
    if (director_.may_come && director_.may_come()) return false;
    no_more_ = true;
    return true;
  }
  spec->frame = next_frame_++;
  if (spec->dealt_to == 0) spec->dealt_to = layout_.renderers;
  Frame frame;
  frame.geometry = make_geometry(*spec, grid_);
  frame.image = Image::uninitialised(frame.geometry.width, frame.geometry.height);
  frame.filled = {frame.image.width, frame.image.height, -1, -1};
  frame.owners = frame.geometry.owners(layout_.renderers);
  frame.tile_here.resize(std::size_t(frame.geometry.regions.count()));
  frame.gp_reported.resize(std::size_t(layout_.gps));
  frame.renderer_reported.resize(std::size_t(layout_.renderers));
  frame.reports_missing = layout_.gps + layout_.renderers;
  frame.announced = now_seconds();
  frame.stats.frame = spec->frame;
  frame.stats.axis = frame.geometry.traversal.axis;
  frame.stats.ascending = frame.geometry.traversal.ascending;
  frame.stats.slices = frame.geometry.slices;
  frame.stats.gps.resize(std::size_t(layout_.gps));
  frame.stats.renderers.resize(std::size_t(layout_.renderers));
  const Bytes encoded = encode(*spec);
  Bytes body = Message::body_buffer();
  body.insert(body.end(), encoded.begin(), encoded.end());
  Message message({.kind = Kind::frame_spec, .source_role = Role::frame_buffer, .frame = spec->frame},
                  std::move(body));
  frame.spec = std::move(*spec);
  frames_.push_back(std::move(frame));
  announce_(std::move(message));
  return true;
}

FrameBuffer::Frame& FrameBuffer::frame_of(const Header& h) {
  for (auto& frame : frames_)
    if (frame.spec.frame == h.frame) return frame;
  throw RunError(fmt::format("the frame buffer got a {} of frame {} from {}, which is not being rendered",
                             name(h.kind), h.frame, to_string(h.from())));
}

void FrameBuffer::receive(Message message) {
  const Header& h = message.header;
  if (h.kind == Kind::link_report) {
    take_link_report(message);
    return;
  }
  Frame& frame = frame_of(h);
  switch (h.kind) {
    case Kind::tile:
      take_tile(frame, message);
      return;
    case Kind::report:
      take_report(frame, message);
      return;
    default:
      throw RunError(
          fmt::format("the frame buffer cannot use a {} (from {})", name(h.kind), to_string(h.from())));
  }
}

void FrameBuffer::take_tile(Frame& frame, const Message& message) {
  const Header& h = message.header;
  const Regions& regions = frame.geometry.regions;
  const auto region = static_cast<int>(h.region);
  if (region < 0 || region >= regions.count() || h.source_role != Role::renderer ||
      frame.owners->of(region) != h.source || frame.tile_here[h.region])
    throw RunError(fmt::format("{} delivered region {} of frame {}, which is not its own or came before",
                               to_string(h.from()), h.region, h.frame));
  const PixelRect rect = regions.rect(region);
  const std::size_t row_bytes = std::size_t(rect.width()) * 4 * sizeof(float);
  if (message.body().size() != row_bytes * std::size_t(rect.height()))
    throw RunError(fmt::format("{} delivered {} bytes for region {} of frame {}", to_string(h.from()),
                               h.bytes, region, h.frame));
  for (int y = 0; y < rect.height(); ++y)
    std::memcpy(frame.image.pixel(rect.x0, rect.y0 + y), message.body().data() + std::size_t(y) * row_bytes,
                row_bytes);
  PixelWindow& filled = frame.filled;
  filled = {std::min<std::int64_t>(filled.x0, rect.x0), std::min<std::int64_t>(filled.y0, rect.y0),
            std::max<std::int64_t>(filled.x1, rect.x1 - 1), std::max<std::int64_t>(filled.y1, rect.y1 - 1)};
  frame.tile_here[h.region] = true;
  ++frame.tiles_here;
}

void FrameBuffer::take_report(Frame& frame, const Message& message) {
  const Header& h = message.header;
  NodeStats stats;
  std::size_t at = 0;
  if (!take(message.body(), at, stats) || at != message.body().size())
    throw RunError(fmt::format("{} sent a report of {} bytes", to_string(h.from()), h.bytes),
                   "all ranks must run the same build");
  const bool from_gp = h.source_role == Role::gp;
  if (!from_gp && h.source_role != Role::renderer)
    throw RunError(
        fmt::format("{} reported frame {}, in which it has no part", to_string(h.from()), h.frame));
  auto reported = (from_gp ? frame.gp_reported : frame.renderer_reported)[std::size_t(h.source)];
  if (reported) throw RunError(fmt::format("{} reported frame {} twice", to_string(h.from()), h.frame));
  reported = true;
  (from_gp ? frame.stats.gps : frame.stats.renderers)[std::size_t(h.source)] = stats;
  frame.tiles_reported += stats.tiles;
  --frame.reports_missing;
}

/// Most pixels come with tiles.
void FrameBuffer::clear_where_no_tile_came(Frame& frame) {
  for (int region = 0; region < frame.geometry.regions.count(); ++region) {
    if (frame.tile_here[std::size_t(region)]) continue;
    const PixelRect rect = frame.geometry.regions.rect(region);
    for (int y = rect.y0; y < rect.y1; ++y)
      std::fill(frame.image.pixel(rect.x0, y), frame.image.pixel(rect.x1, y), 0.0F);
  }
}

void FrameBuffer::complete(Frame&& frame) {
  if (!frame.stats.dropped) clear_where_no_tile_came(frame);
  if (frame.geometry.warp && !frame.stats.dropped)
    frame.image =
        warp_image(frame.image, frame.filled, *frame.geometry.warp, frame.spec.width, frame.spec.height);
  const double now = now_seconds();
  frame.stats.seconds = now - frame.announced;
  frame.stats.period = now - std::max(frame.announced, last_completed_);
  last_completed_ = now;
  if (options_.trace)
    options_.trace->of(id())->add(Activity::frame, frame.spec.frame, -1, frame.announced, now);
  check_conservation(frame.stats);
  FrameResult result{std::move(frame.spec), std::move(frame.image), std::move(frame.stats)};
  if (!layout_.routed()) {
    if (!result.stats.dropped) director_.frame_done(std::move(result));
    return;
  }
  const auto ranks = std::size_t(layout_.ranks());
  const std::int64_t number = result.spec.frame;
  settling_.push_back({std::move(result), std::vector<std::vector<LinkCounts>>(ranks),
                       std::vector<bool>(ranks), layout_.ranks()});
  announce_(Message({.kind = Kind::link_query, .source_role = Role::frame_buffer, .frame = number}));
}

void FrameBuffer::take_link_report(const Message& message) {
  const Header& h = message.header;
  const auto frame = std::find_if(settling_.begin(), settling_.end(),
                                  [&](const Settling& s) { return s.result.spec.frame == h.frame; });
  const auto rank = std::size_t(h.source);
  if (frame == settling_.end() || h.source_role != Role::host || frame->reported[rank])
    throw RunError(
        fmt::format("{} reported its links for frame {} without being asked", to_string(h.from()), h.frame));
  frame->links[rank] = decode_link_counts(message.body(), layout_, h.source);
  frame->reported[rank] = true;
  --frame->reports_missing;
}

void FrameBuffer::hand_over(Settling&& settled) {
  for (const auto& counts : settled.links)
    settled.result.stats.links.insert(settled.result.stats.links.end(), counts.begin(), counts.end());
  if (!settled.result.stats.dropped) director_.frame_done(std::move(settled.result));
}

std::string FrameBuffer::waiting_for() const {
  if (frames_.empty() && !settling_.empty())
    return fmt::format("the frame buffer waits for {} rank(s) to report their links for frame {}",
                       settling_.front().reports_missing, settling_.front().result.spec.frame);
  if (frames_.empty()) return {};
  const Frame& f = frames_.front();
  std::string who;
  for (int g = 0; g < layout_.gps; ++g)
    if (!f.gp_reported[std::size_t(g)]) who += fmt::format("{}GP {}", who.empty() ? "" : ", ", g);
  for (int r = 0; r < layout_.renderers; ++r)
    if (!f.renderer_reported[std::size_t(r)]) who += fmt::format("{}Renderer {}", who.empty() ? "" : ", ", r);
  if (who.empty())
    return fmt::format("the frame buffer waits for {} tile(s) of frame {}", f.tiles_reported - f.tiles_here,
                       f.spec.frame);
  return fmt::format("the frame buffer waits for reports on frame {} from {}", f.spec.frame, who);
}

}  // namespace ringsplat
