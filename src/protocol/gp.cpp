#include "protocol/gp.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "ringsplat/base/error.hpp"

namespace ringsplat {

GpFrame::GpFrame(int gp, const Announcement& announcement, int renderers, Engine& engine)
    : number(announcement.frame),
      plan(engine.plan(announcement)),
      drawing(plan.drawing(renderers)),
      tokens(int(std::count(drawing.begin(), drawing.end(), true))),
      encoder(engine.encoder(gp, announcement)),
      shown(encoder->shown()) {
  // With nothing to show, tokens still visit one step: Renderers wait to learn that no payload comes.
  if (shown.empty()) shown.push_back(0);
  for (const int step : shown)
    if (plan.owners[std::size_t(step)] == gp) steps.push_back(step);
  if (tokens > 0) return;
  // The volume lies beside the picture.
  stats.voxels_outside = encoder->left_out(steps.size()).outside;
  steps.clear();
}

bool GpFrame::owns(int step) const { return std::binary_search(steps.begin(), steps.end(), step); }

std::optional<int> GpFrame::after(int step) const {
  const auto next = std::upper_bound(shown.begin(), shown.end(), step);
  return next == shown.end() ? std::nullopt : std::optional(*next);
}

PreparedSlice* GpFrame::find_slice(int step) {
  const auto found =
      std::find_if(prepared.begin(), prepared.end(), [&](const PreparedSlice& s) { return s.step == step; });
  return found == prepared.end() ? nullptr : &*found;
}

void GpFrame::retire_slices() {
  while (!prepared.empty() && prepared.front().tokens_left == 0) {
    prepared.pop_front();
    ++steps_done;
  }
}

/// Owner of the shown step before this one, or of the first shown step.
int GpFrame::owner_before(int step) const {
  const auto here = std::lower_bound(shown.begin(), shown.end(), step);
  return plan.owners[std::size_t(here == shown.begin() ? shown.front() : *std::prev(here))];
}

std::string GpFrame::waiting_for(const std::string& gp) const {
  if (!prepared.empty()) {
    const PreparedSlice& slice = prepared.front();
    if (!slice.awaiting_accept.empty())
      return fmt::format("{} waits for Renderer {} to accept step {} of frame {}", gp,
                         slice.awaiting_accept.begin()->first, slice.step, number);
    return fmt::format("{} waits for {} token(s) of step {} of frame {} from GP {}", gp, slice.tokens_left,
                       slice.step, number, owner_before(slice.step));
  }
  if (steps_done < steps.size()) return fmt::format("{} has slices of frame {} left to encode", gp, number);
  if (!left_behind.empty())
    return fmt::format("{} waits for Renderer {} to accept a payload of frame {}", gp,
                       left_behind.begin()->first, number);
  return {};
}

Gp::Gp(int index, const Layout& layout, const ProtocolOptions& options, Engine& engine, Post post)
    : index_(index),
      layout_(layout),
      options_(options),
      engine_(engine),
      post_(std::move(post)),
      book_(id(), options.trace) {}

void Gp::begin_frame(const Announcement& announcement) {
  frames_.push_back(std::make_unique<Frame>(index_, announcement, layout_.renderers, engine_));
  if (frames_.back()->owns_front()) start_tokens(*frames_.back());
  for (auto& message : early_.release(announcement.frame)) receive(std::move(message));
  finish_completed_frames();
}

/// All tokens start at the owner of the front slice and visit slices in the traversal's order; that order
/// keeps a mesh free of contention (net/mesh.hpp).
void Gp::start_tokens(Frame& frame) {
  auto& front = frame.waiting_tokens[frame.shown.front()];
  for (int k = 0; k < layout_.renderers; ++k) {
    const int renderer = frame.plan.ascending ? k : layout_.renderers - 1 - k;
    if (frame.drawing[std::size_t(renderer)])
      front.push_back({renderer, 0, credits_of(std::uint32_t(options_.slots))});
  }
  frame.stats.tokens_issued = front.size();
}

void Gp::drop_frame(std::int64_t number) {
  // Not when this GP's part is over. What is prepared is still sent: later payloads may rely on it.
  if (Frame* frame = find_frame(number)) frame->dropped = true;
}

Gp::Frame* Gp::find_frame(std::int64_t number) {
  for (const auto& frame : frames_)
    if (frame->number == number) return frame.get();
  return nullptr;
}

void Gp::receive(Message message) {
  if (early_.keep(message)) return;
  const Header& h = message.header;
  Frame* frame = find_frame(h.frame);
  if (frame == nullptr)
    throw RunError(fmt::format("{} got a {} of frame {} from {} after that frame was over", to_string(id()),
                               name(h.kind), h.frame, to_string(h.from())));
  switch (h.kind) {
    case Kind::token:
      take_token(*frame, h);
      break;
    case Kind::accept:
      take_accept(*frame, h);
      frame->encoder->take_news(message.body());
      break;
    default:
      refuse(id(), h);
  }
  finish_completed_frames();
}

void Gp::take_token(Frame& frame, const Header& h) {
  const auto [place, credits] = fields_of<TokenFields>(h);
  if (!frame.owns(place.step))
    throw RunError(
        fmt::format("{} got Renderer {}'s token for step {} of frame {}, whose slice is not its own",
                    to_string(id()), place.renderer, place.step, h.frame));
  book_.mark(Moment::take_token, h.frame, place.step, place.renderer);
  const HeldToken token{place.renderer, place.sequence, credits};
  if (PreparedSlice* slice = frame.find_slice(place.step))
    use_token(frame, *slice, token);
  else
    frame.waiting_tokens[place.step].push_back(token);
}

void Gp::use_token(Frame& frame, PreparedSlice& slice, HeldToken token) {
  EncodedPart& part = slice.parts[std::size_t(token.renderer)];
  if (part.payload.empty()) {
    pass_token(frame, slice, token);
    return;
  }
  const Header h = make_header(
      id(), {Role::renderer, token.renderer}, frame.number,
      PayloadFields{.place = {slice.step, token.renderer, token.sequence}, .passes = part.passes});
  frame.stats.splats_sent += part.items;
  frame.stats.payload_bytes_sent += Message::body_size(part.payload);
  ++frame.stats.payloads_sent;
  book_.mark(Moment::send_payload, frame.number, slice.step, token.renderer);
  post_(Message(h, std::exchange(part.payload, {})));
  if (token.credits == 0) {
    slice.awaiting_accept[token.renderer] = token.sequence;
    return;
  }
  frame.left_behind.emplace(token.renderer, token.sequence);
  pass_token(frame, slice, {token.renderer, token.sequence + 1, token.credits - 1});
}

/// In a mesh a token waits for every accept, so that payloads never meet (net/mesh.hpp).
std::uint32_t Gp::credits_of(std::uint32_t free_slots) const {
  return layout_.routed() ? 0 : std::min(free_slots, std::uint32_t(options_.send_ahead));
}

void Gp::take_accept(Frame& frame, const Header& h) {
  const auto [place, free_slots] = fields_of<AcceptFields>(h);
  if (frame.left_behind.erase({place.renderer, place.sequence}) > 0) return;
  if (PreparedSlice* slice = frame.find_slice(place.step)) {
    const auto sent = slice->awaiting_accept.find(place.renderer);
    if (sent != slice->awaiting_accept.end() && sent->second == place.sequence) {
      slice->awaiting_accept.erase(sent);
      pass_token(frame, *slice, {place.renderer, place.sequence + 1, credits_of(free_slots)});
      return;
    }
  }
  throw RunError(
      fmt::format("{} got an accept from {} for payload {} of step {}, frame {}, which it did not send",
                  to_string(id()), to_string(h.from()), place.sequence, place.step, h.frame));
}

void Gp::pass_token(Frame& frame, PreparedSlice& slice, HeldToken token) {
  --slice.tokens_left;
  const std::optional<int> next = frame.after(slice.step);
  if (!next) {
    ++frame.stats.tokens_retired;
    post_(Message(make_header(id(), {Role::renderer, token.renderer}, frame.number,
                              FrameEndFields{.payloads = token.sequence})));
    return;
  }
  ++frame.stats.tokens_passed;
  book_.mark(Moment::pass_token, frame.number, *next, token.renderer);
  post_(Message(
      make_header(id(), {Role::gp, frame.plan.owners[std::size_t(*next)]}, frame.number,
                  TokenFields{.place = {*next, token.renderer, token.sequence}, .credits = token.credits})));
}

bool Gp::advance() {
  finish_completed_frames();
  book(waiting());
  const Turn turn = encode_some();
  book(turn.activity ? turn : waiting());
  return turn.activity.has_value();
}

bool Gp::amid_slice() const {
  return std::any_of(frames_.begin(), frames_.end(), [](const auto& frame) { return frame->encoding; });
}

std::size_t Gp::prepared_slices() const {
  std::size_t count = 0;
  for (const auto& frame : frames_) count += frame->prepared.size();
  return count;
}

/// Encodes a piece of the next slice; idle when there is none, or no room for it.
Turn Gp::encode_some() {
  // The earliest frame with slices left: a later frame's slices never take the room an earlier one needs.
  const auto found = std::find_if(frames_.begin(), frames_.end(),
                                  [](const auto& f) { return f->next_step < f->steps.size(); });
  if (found == frames_.end()) return {};
  Frame& frame = **found;
  Encoder& encoder = *frame.encoder;
  const int step = frame.steps[frame.next_step];
  const StageSeconds before = encoder.stages();
  const auto worked = [&]() -> Turn {
    const StageSeconds after = encoder.stages();
    return {
        Activity::slice, frame.number, step, {after.classify - before.classify, after.shade - before.shade}};
  };
  if (encoder.prepare()) return worked();
  if (!frame.encoding) {
    if (prepared_slices() >= std::size_t(options_.look_ahead)) return {};
    encoder.begin(step);
    frame.encoding = true;
  }
  if (frame.dropped)
    prepare_slice(frame, {std::vector<EncodedPart>(std::size_t(layout_.renderers)), {}});
  else if (encoder.work())
    prepare_slice(frame, encoder.finish());
  return worked();
}

void Gp::prepare_slice(Frame& frame, EncodedStep&& encoded) {
  frame.encoding = false;
  frame.stats.slices += std::uint64_t(encoded.slices);
  for (const auto& part : encoded.parts) frame.stats.passes += part.passes;
  frame.stats.blocks += encoded.counts.blocks;
  frame.stats.visible_voxels += encoded.counts.visible;
  frame.stats.voxels_outside += encoded.counts.outside;
  const int step = frame.steps[frame.next_step++];
  frame.prepared.push_back({step, std::move(encoded.parts), frame.tokens, {}});
  PreparedSlice& slice = frame.prepared.back();
  const auto waiting = frame.waiting_tokens.extract(step);
  if (waiting.empty()) return;
  for (const HeldToken& token : waiting.mapped()) use_token(frame, slice, token);
}

void Gp::finish_completed_frames() {
  for (const auto& frame : frames_) frame->retire_slices();
  while (!frames_.empty() && frames_.front()->done()) {
    book(waiting());
    report(*frames_.front());
    frames_.pop_front();
  }
}

void Gp::report(Frame& frame) {
  frame.stats.slice_memory = frame.encoder->slice_memory();
  post_(make_report(id(), frame.number, frame.stats));
}

/// What this node waits for on its oldest frame.
Turn Gp::waiting() const {
  if (frames_.empty() || frames_.front()->prepared.empty()) return {};
  const Frame& frame = *frames_.front();
  const auto sent = std::find_if(frame.prepared.begin(), frame.prepared.end(),
                                 [](const PreparedSlice& s) { return !s.awaiting_accept.empty(); });
  if (sent != frame.prepared.end()) return {Activity::send, frame.number, sent->step};
  return {Activity::wait_for_token, frame.number, frame.prepared.front().step};
}

/// Books a turn on the oldest frame.
void Gp::book(const Turn& turn) { book_.turn(turn, frames_.empty() ? nullptr : &frames_.front()->stats); }

std::string Gp::waiting_for() const {
  for (const auto& frame : frames_)
    if (const std::string what = frame->waiting_for(to_string(id())); !what.empty()) return what;
  return {};
}

}  // namespace ringsplat
