#include "ringsplat/node/renderer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "node/counting_engine.hpp"
#include "ringsplat/base/clock.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/base/process.hpp"

namespace ringsplat {

Renderer::Renderer(int index, const Layout& layout, const ProtocolOptions& options, const Grid& grid,
                   Post post)
    : index_(index),
      layout_(layout),
      options_(options),
      grid_(grid),
      post_(std::move(post)),
      threads_(options.threads_per_rank),
      painter_(options.simulation.count_only ? make_counting_painter(index, layout.renderers)
                                             : make_painter(index, layout.renderers, threads_)),
      debt_(options.simulation.machine ? options.simulation.machine->poll_interval : 1),
      last_time_(now_seconds()),
      trace_(options.trace ? options.trace->of(id()) : nullptr) {}

void Renderer::begin_frame(const FrameSpec& spec) {
  frames_.emplace_back().spec = spec;
  next_frame_ = spec.frame + 1;
  auto waiting = std::exchange(early_, {});
  for (auto& message : waiting) receive(std::move(message));
}

void Renderer::drop_frame(std::int64_t number) {
  for (auto& frame : frames_)
    if (frame.spec.frame == number) frame.dropped = true;
}

Renderer::Frame& Renderer::frame_of(const Header& h) {
  for (auto& frame : frames_)
    if (frame.spec.frame == h.frame) return frame;
  throw RunError(fmt::format("{} got a {} of frame {} from {} after that frame was delivered",
                             to_string(id()), name(h.kind), h.frame, to_string(h.from())));
}

void Renderer::receive(Message message) {
  const Header& h = message.header;
  if (h.frame >= next_frame_) {
    early_.push_back(std::move(message));
    return;
  }
  Frame& frame = frame_of(h);
  switch (h.kind) {
    case Kind::payload:
      take_payload(frame, std::move(message));
      return;
    case Kind::frame_end:
      if (frame.payloads_expected)
        throw RunError(fmt::format("{} was told twice that frame {} is complete", to_string(id()), h.frame));
      frame.payloads_expected = h.sequence;
      return;
    default:
      throw RunError(
          fmt::format("{} cannot use a {} (from {})", to_string(id()), name(h.kind), to_string(h.from())));
  }
}

void Renderer::take_payload(Frame& frame, Message message) {
  const Header h = message.header;
  frame.stats.payload_bytes_received += h.bytes;
  if (trace_) trace_->mark(Moment::take_payload, h.frame, h.step, h.renderer, now_seconds());
  if (h.sequence < frame.next || !frame.payloads.emplace(h.sequence, std::move(message)).second)
    throw RunError(fmt::format("{} got payload {} of frame {} twice, the second time from {}",
                               to_string(id()), h.sequence, h.frame, to_string(h.from())));
  if (h.sequence > slots_end(frame))
    throw RunError(fmt::format("{} got payload {} of frame {} from {} while it had slots for those before {}",
                               to_string(id()), h.sequence, h.frame, to_string(h.from()), slots_end(frame)));
  if (h.sequence < slots_end(frame)) accept(frame, h);
}

/// Payloads have slots in the order of their numbers, not of their arrival: those before one that is here
/// were all sent, and need theirs. So only the payload of this number can be here and wait for one.
std::uint32_t Renderer::slots_end(const Frame& frame) const {
  return frame.next + std::uint32_t(options_.slots);
}

void Renderer::accept(const Frame& frame, Header h) {
  h.region = slots_end(frame) - 1 - h.sequence;
  std::swap(h.source, h.destination);
  std::swap(h.source_role, h.destination_role);
  h.kind = Kind::accept;
  Bytes news;
  if (frame.begun) painter_->opaque_news(h.destination, news);
  post_(Message(h, std::move(news)));
}

bool Renderer::advance() {
  account_time(&NodeStats::idle);
  if (frames_.empty()) return false;
  Frame& frame = frames_.front();
  if (!frame.begun) {
    const FrameGeometry geometry = make_geometry(frame.spec, grid_);
    painter_->begin_frame(frame.spec, geometry);
    frame.begun = true;
    // No token goes round for a Renderer without a region.
    if (!geometry.drawing(layout_.renderers)[std::size_t(index_)]) frame.payloads_expected = 0;
    if (const auto& machine = options_.simulation.machine) debt_.owe(machine->renderer.frame);
  }
  if (!frame.painting && debt_.pay()) {
    account_time(&NodeStats::drawing);
    return true;
  }
  if (frame.drawn()) {
    deliver(frame);
    return true;
  }
  return draw_some(frame);
}

bool Renderer::draw_some(Frame& frame) {
  const auto found = frame.payloads.find(frame.next);
  if (found == frame.payloads.end()) return false;
  if (frame.dropped) {
    finish_payload(frame);
    return true;
  }
  if (!frame.painting) {
    painter_->begin(found->second.header.step, found->second.body());
    frame.splats_before = painted_splats();
    frame.painting = true;
  }
  const double begun = last_time_, composited = painter_->composite_seconds();
  bool complete = frame.painted;
  if (!complete) {
    complete = frame.painted = painter_->work();
    if (complete) owe_drawing(found->second.header, painted_splats() - frame.splats_before);
  }
  complete = complete && !debt_.pay();
  account_time(&NodeStats::drawing);
  if (trace_) {
    const double drawn = std::max(begun, last_time_ - (painter_->composite_seconds() - composited));
    const std::int32_t step = found->second.header.step;
    trace_->add(Activity::draw, frame.spec.frame, step, begun, drawn);
    if (drawn < last_time_) trace_->add(Activity::composite, frame.spec.frame, step, drawn, last_time_);
  }
  if (!complete) return true;

  finish_payload(frame);
  return true;
}

void Renderer::finish_payload(Frame& frame) {
  frame.painting = frame.painted = false;
  frame.payloads.erase(frame.next);
  ++frame.next;
  ++frame.stats.payloads_drawn;
  const auto waiting = frame.payloads.find(slots_end(frame) - 1);
  if (waiting != frame.payloads.end()) accept(frame, waiting->second.header);
}

std::uint64_t Renderer::painted_splats() const {
  const PaintCounts counts = painter_->counts();
  return counts.drawn + counts.clipped;
}

void Renderer::owe_drawing(const Header& payload, std::uint64_t splats) {
  if (const auto& machine = options_.simulation.machine)
    debt_.owe(drawing_seconds(*machine, double(splats), double(payload.region)));
}

void Renderer::deliver(Frame& frame) {
  NodeStats& stats = frame.stats;
  const auto send_tile = [&](int region, Bytes rgba) {
    ++stats.tiles;
    stats.tile_bytes += Message::body_size(rgba);
    constexpr double bytes_of_pixel = 4 * sizeof(float);
    if (const auto& machine = options_.simulation.machine)
      charge(machine->renderer.pixel * double(Message::body_size(rgba)) / bytes_of_pixel);
    Header h{.kind = Kind::tile,
             .source_role = Role::renderer,
             .destination_role = Role::frame_buffer,
             .source = index_,
             .frame = frame.spec.frame};
    h.region = static_cast<std::uint32_t>(region);
    post_(Message(h, std::move(rgba)));
  };
  if (!frame.dropped) painter_->finish(send_tile);
  const double begun = last_time_;
  account_time(&NodeStats::delivering);
  if (trace_) trace_->add(Activity::deliver, frame.spec.frame, -1, begun, last_time_);

  const PaintCounts counts = painter_->counts();
  stats.splats_drawn = counts.drawn;
  stats.splats_clipped = counts.clipped;
  stats.splats_hidden = counts.hidden;
  stats.compositing = painter_->composite_seconds();
  stats.drawing -= stats.compositing;
  stats.peak_memory = peak_memory_bytes();
  Bytes body = Message::body_buffer();
  append(body, stats);
  post_(Message({.kind = Kind::report,
                 .source_role = Role::renderer,
                 .destination_role = Role::frame_buffer,
                 .source = index_,
                 .frame = frame.spec.frame},
                std::move(body)));
  frames_.pop_front();
}

/// Books the time since the last call on the frame being drawn.
void Renderer::account_time(double NodeStats::*part) {
  const double now = now_seconds();
  const double passed = now - std::exchange(last_time_, now);
  if (!frames_.empty()) frames_.front().stats.*part += passed;
}

std::string Renderer::waiting_for() const {
  if (frames_.empty()) return {};
  const Frame& frame = frames_.front();
  if (frame.payloads.contains(frame.next))
    return fmt::format("{} has payload {} of frame {} to draw", to_string(id()), frame.next,
                       frame.spec.frame);
  if (!frame.payloads_expected)
    return fmt::format("{} waits for payload {} of frame {} or for its end", to_string(id()), frame.next,
                       frame.spec.frame);
  return fmt::format("{} waits for payload {} of {} of frame {}", to_string(id()), frame.next,
                     *frame.payloads_expected, frame.spec.frame);
}

}  // namespace ringsplat
