#include "ringsplat/node/gp.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "node/counting_engine.hpp"
#include "node/empty_space.hpp"
#include "ringsplat/base/clock.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/base/process.hpp"

namespace ringsplat {

/// A slice whose payloads are made, until all its tokens have passed.
struct Gp::PreparedSlice {
  int step;
  EncodedSlice encoded;
  int tokens_left;                               ///< that have not yet passed
  std::map<int, std::uint32_t> awaiting_accept;  ///< Renderer → sequence of the payload sent to it
};

struct Gp::Frame {
  FrameSpec spec;
  FrameGeometry geometry;
  const SliceStore* store = nullptr;  ///< of the frame's level
  std::unique_ptr<Encoder> encoder;
  std::vector<int> shown;     ///< traversal steps of slices that tokens go through, ascending
  std::vector<int> steps;     ///< of these, this GP's
  int tokens = 0;             ///< one for each Renderer that has a region
  std::size_t next_step = 0;  ///< into `steps`: the next to encode
  bool encoding = false;
  std::optional<EncodedSlice> encoded;  ///< complete, while the simulated time for it passes
  std::deque<PreparedSlice> prepared;
  std::map<int, std::vector<HeldToken>>
      waiting_tokens;  ///< step → tokens that came before the slice was ready
  std::set<std::pair<int, std::uint32_t>>
      left_behind;  ///< Renderer and sequence of payloads whose tokens moved on before they were accepted
  std::size_t steps_done = 0;
  bool dropped = false;  ///< slices not yet sent are left out
  NodeStats stats;

  /// The next of the shown steps, or none.
  std::optional<int> after(int step) const {
    const auto next = std::upper_bound(shown.begin(), shown.end(), step);
    return next == shown.end() ? std::nullopt : std::optional(*next);
  }
  /// The one before, or the first.
  int before(int step) const {
    const auto here = std::lower_bound(shown.begin(), shown.end(), step);
    return here == shown.begin() ? shown.front() : *std::prev(here);
  }

  bool done() const { return steps_done == steps.size() && left_behind.empty(); }
};

Gp::Gp(int index, const Layout& layout, const ProtocolOptions& options, SliceStore slices, Post post)
    : index_(index),
      layout_(layout),
      options_(options),
      slices_(std::move(slices)),
      post_(std::move(post)),
      threads_(options.threads_per_rank),
      debt_(options.simulation.machine ? options.simulation.machine->poll_interval : 1),
      last_time_(now_seconds()),
      trace_(options.trace ? options.trace->of(id()) : nullptr) {}

Gp::~Gp() = default;

void Gp::begin_frame(const FrameSpec& spec) {
  auto frame = std::make_unique<Frame>();
  frame->spec = spec;
  frame->geometry = make_geometry(spec, slices_.grid());
  const Traversal& traversal = frame->geometry.traversal;
  const std::vector<bool> drawing = frame->geometry.drawing(layout_.renderers);
  frame->tokens = int(std::count(drawing.begin(), drawing.end(), true));
  frame->store = &slices_.level(spec.reduction.factor);
  if (!frame->store->keeps(traversal.axis))
    throw RunError(fmt::format("frame {} traverses the {} axis, whose slices were not loaded", spec.frame,
                               name(traversal.axis)),
                   "load it with --axes all");
  if (spec.shading == Shading::phong && !frame->store->has_normals())
    throw RunError(fmt::format("frame {} is shaded, but no normals were loaded", spec.frame),
                   "load them with --shading phong");
  find_steps(*frame);
  if (frame->tokens == 0) {
    // The volume lies beside the picture.
    frame->stats.voxels_outside =
        frame->steps.size() * std::uint64_t(frame->geometry.grid.slice_voxels(traversal.axis));
    frame->steps.clear();
  }
  if (!frame->steps.empty()) {
    frame->encoder = make_encoder(frame->spec, frame->geometry, layout_.renderers,
                                  empty_space_of(spec.reduction.factor), threads_);
    if (const auto& simulation = options_.simulation; simulation.count_only)
      frame->encoder = make_counting_encoder(std::move(frame->encoder), frame->spec, frame->geometry,
                                             layout_.renderers, simulation.voxel_weight);
    if (trace_) frame->encoder->time_stages(&piece_.stages);
    if (const auto& machine = options_.simulation.machine) debt_.owe(machine->gp.frame);
    if (frame->steps.front() == frame->shown.front()) {
      // All tokens start at the owner of the front slice.
      auto& front = frame->waiting_tokens[frame->shown.front()];
      // Their order follows the traversal's, which is what keeps a mesh free of contention (net/mesh.hpp).
      for (int k = 0; k < layout_.renderers; ++k) {
        const int renderer = traversal.ascending ? k : layout_.renderers - 1 - k;
        if (drawing[std::size_t(renderer)])
          front.push_back({renderer, 0, credits_of(std::uint32_t(options_.slots))});
      }
      frame->stats.tokens_issued = front.size();
    }
  }
  frames_.push_back(std::move(frame));
  next_frame_ = spec.frame + 1;

  auto waiting = std::exchange(early_, {});
  for (auto& message : waiting) receive(std::move(message));
  finish_completed_frames();
}

/// Slices that the transfer function makes transparent have no part in the frame, not even a token's way. A
/// mesh goes through all: that tokens visit GPs in their order is what keeps its payloads from meeting
/// (net/mesh.hpp); and a described machine looks at every voxel, as its costs say.
void Gp::find_steps(Frame& frame) {
  const Traversal& traversal = frame.geometry.traversal;
  const int slices = frame.geometry.slices;
  const std::vector<bool>* shown = nullptr;
  const SimulationOptions& simulation = options_.simulation;
  if (!layout_.routed() && !simulation.machine && !simulation.count_only)
    shown = &empty_space_of(frame.spec.reduction.factor)
                 .shown_slices(*frame.store, traversal.axis, frame.spec.transfer_function);
  for (int step = 0; step < slices; ++step)
    if (shown == nullptr || (*shown)[std::size_t(traversal.slice_at(step, slices))])
      frame.shown.push_back(step);
  // Renderers wait to be told that nothing comes.
  if (frame.shown.empty()) frame.shown.push_back(0);
  for (const int step : frame.shown)
    if (layout_.gp_of_slice(traversal.slice_at(step, slices)) == index_) frame.steps.push_back(step);
}

void Gp::drop_frame(std::int64_t number) {
  Frame* frame = find_frame(number);
  if (frame == nullptr) return;  // this GP's part is over
  frame->dropped = true;
  for (auto& slice : frame->prepared) slice.encoded.payloads.assign(std::size_t(layout_.renderers), {});
}

EmptySpace& Gp::empty_space_of(int level) {
  auto& space = empty_space_[level];
  if (!space) space = std::make_unique<EmptySpace>();
  return *space;
}

Gp::Frame* Gp::find_frame(std::int64_t frame) {
  for (const auto& f : frames_)
    if (f->spec.frame == frame) return f.get();
  return nullptr;
}

void Gp::receive(Message message) {
  const Header& h = message.header;
  if (h.frame >= next_frame_) {
    early_.push_back(std::move(message));
    return;
  }
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
      frame->encoder->take_opaque_news(message.body());
      break;
    default:
      throw RunError(
          fmt::format("{} cannot use a {} (from {})", to_string(id()), name(h.kind), to_string(h.from())));
  }
  finish_completed_frames();
}

void Gp::take_token(Frame& frame, const Header& h) {
  if (!std::binary_search(frame.steps.begin(), frame.steps.end(), h.step))
    throw RunError(
        fmt::format("{} got Renderer {}'s token for step {} of frame {}, whose slice is not its own",
                    to_string(id()), h.renderer, h.step, h.frame));
  const HeldToken token{h.renderer, h.sequence, h.region};
  if (trace_) trace_->mark(Moment::take_token, h.frame, h.step, h.renderer, now_seconds());
  for (auto& slice : frame.prepared) {
    if (slice.step != h.step) continue;
    use_token(frame, slice, token);
    return;
  }
  frame.waiting_tokens[h.step].push_back(token);
}

void Gp::use_waiting_tokens(Frame& frame, PreparedSlice& slice) {
  const auto found = frame.waiting_tokens.find(slice.step);
  if (found == frame.waiting_tokens.end()) return;
  const auto tokens = std::move(found->second);
  frame.waiting_tokens.erase(found);
  for (const auto& token : tokens) use_token(frame, slice, token);
}

void Gp::use_token(Frame& frame, PreparedSlice& slice, HeldToken token) {
  Bytes& payload = slice.encoded.payloads[std::size_t(token.renderer)];
  if (payload.empty()) {
    pass_token(frame, slice, token);
    return;
  }
  Header h{.kind = Kind::payload,
           .source_role = Role::gp,
           .destination_role = Role::renderer,
           .counted = options_.simulation.count_only,
           .source = index_,
           .destination = token.renderer,
           .frame = frame.spec.frame,
           .step = slice.step,
           .renderer = token.renderer,
           .sequence = token.sequence,
           .region = slice.encoded.passes[std::size_t(token.renderer)]};
  frame.stats.splats_sent += slice.encoded.splats[std::size_t(token.renderer)];
  frame.stats.payload_bytes_sent += Message::body_size(payload);
  ++frame.stats.payloads_sent;
  if (trace_) trace_->mark(Moment::send_payload, h.frame, h.step, h.renderer, now_seconds());
  post_(Message(h, std::move(payload)));
  payload = {};
  if (token.credits == 0) {
    slice.awaiting_accept[token.renderer] = token.sequence;
    return;
  }
  frame.left_behind.emplace(token.renderer, token.sequence);
  pass_token(frame, slice, {token.renderer, token.sequence + 1, token.credits - 1});
}

/// In a mesh a token waits for every accept: that is what keeps payloads from meeting (net/mesh.hpp).
std::uint32_t Gp::credits_of(std::uint32_t free_slots) const {
  return layout_.routed() ? 0 : std::min(free_slots, std::uint32_t(options_.send_ahead));
}

void Gp::take_accept(Frame& frame, const Header& h) {
  if (frame.left_behind.erase({h.renderer, h.sequence}) > 0) return;
  for (auto& slice : frame.prepared) {
    if (slice.step != h.step) continue;
    const auto sent = slice.awaiting_accept.find(h.renderer);
    if (sent == slice.awaiting_accept.end() || sent->second != h.sequence) break;
    slice.awaiting_accept.erase(sent);
    pass_token(frame, slice, {h.renderer, h.sequence + 1, credits_of(h.region)});
    return;
  }
  throw RunError(
      fmt::format("{} got an accept from {} for payload {} of step {}, frame {}, which it did not send",
                  to_string(id()), to_string(h.from()), h.sequence, h.step, h.frame));
}

void Gp::pass_token(Frame& frame, PreparedSlice& slice, HeldToken token) {
  --slice.tokens_left;
  Header h{.source_role = Role::gp,
           .source = index_,
           .frame = frame.spec.frame,
           .renderer = token.renderer,
           .sequence = token.sequence,
           .region = token.credits};
  const std::optional<int> next = frame.after(slice.step);
  if (!next) {
    ++frame.stats.tokens_retired;
    h.kind = Kind::frame_end;
    h.destination_role = Role::renderer;
    h.destination = token.renderer;
  } else {
    ++frame.stats.tokens_passed;
    h.kind = Kind::token;
    h.destination_role = Role::gp;
    h.destination = layout_.gp_of_slice(frame.geometry.traversal.slice_at(*next, frame.geometry.slices));
    h.step = *next;
    if (trace_) trace_->mark(Moment::pass_token, h.frame, h.step, h.renderer, now_seconds());
  }
  post_(Message(h));
}

bool Gp::advance() {
  finish_completed_frames();
  account_time(false);
  const bool worked = encode_some();
  account_time(worked);
  return worked;
}

bool Gp::amid_slice() const {
  return std::any_of(frames_.begin(), frames_.end(), [](const auto& frame) { return frame->encoding; });
}

std::size_t Gp::prepared_slices() const {
  std::size_t count = 0;
  for (const auto& frame : frames_) count += frame->prepared.size();
  return count;
}

bool Gp::encode_some() {
  if (debt_.pay()) return true;
  // The earliest frame with slices left: a later frame's slices never take the room an earlier one needs.
  const auto found = std::find_if(frames_.begin(), frames_.end(),
                                  [](const auto& f) { return f->next_step < f->steps.size(); });
  if (found == frames_.end()) return false;
  Frame& frame = **found;
  if (!frame.encoding) {
    if (prepared_slices() >= std::size_t(options_.look_ahead)) return false;
    const int slice = frame.geometry.traversal.slice_at(frame.steps[frame.next_step], frame.geometry.slices);
    frame.encoder->begin(frame.store->slice(frame.geometry.traversal.axis, slice));
    frame.encoding = true;
  }
  if (trace_) piece_ = {frame.spec.frame, frame.steps[frame.next_step], {}};
  if (frame.dropped) {
    frame.encoded.emplace().payloads.resize(std::size_t(layout_.renderers));
  } else if (!frame.encoded) {
    if (!frame.encoder->work()) return true;
    frame.encoded = frame.encoder->finish();
    if (const auto& machine = options_.simulation.machine)
      debt_.owe(
          encoding_seconds(*machine, double(frame.encoded->voxels), double(frame.encoded->visible_voxels)));
  }
  if (debt_.pay()) return true;

  frame.encoding = false;
  const int step = frame.steps[frame.next_step++];
  frame.prepared.push_back({step, std::move(*frame.encoded), frame.tokens, {}});
  frame.encoded.reset();
  PreparedSlice& slice = frame.prepared.back();
  ++frame.stats.slices;
  for (const auto passes : slice.encoded.passes) frame.stats.passes += passes;
  frame.stats.visible_voxels += slice.encoded.visible_voxels;
  frame.stats.voxels_outside += slice.encoded.voxels_outside;
  use_waiting_tokens(frame, slice);
  return true;
}

void Gp::finish_completed_frames() {
  for (const auto& frame : frames_) {
    while (!frame->prepared.empty() && frame->prepared.front().tokens_left == 0) {
      frame->prepared.pop_front();
      ++frame->steps_done;
    }
  }
  while (!frames_.empty() && frames_.front()->done()) {
    account_time(false);
    Frame& frame = *frames_.front();
    frame.stats.peak_memory = peak_memory_bytes();
    frame.stats.slice_memory = slices_.allocated_bytes();
    Bytes body = Message::body_buffer();
    append(body, frame.stats);
    post_(Message({.kind = Kind::report,
                   .source_role = Role::gp,
                   .destination_role = Role::frame_buffer,
                   .source = index_,
                   .frame = frame.spec.frame},
                  std::move(body)));
    frames_.pop_front();
  }
}

/// Books the time since the last call on the oldest frame, by what this node was doing meanwhile.
void Gp::account_time(bool computed) {
  const double now = now_seconds();
  const double passed = now - std::exchange(last_time_, now);
  if (frames_.empty()) return;
  if (trace_) trace_time(now - passed, now, computed);
  Frame& frame = *frames_.front();
  const auto sending = [](const PreparedSlice& s) { return !s.awaiting_accept.empty(); };
  if (computed)
    frame.stats.computing += passed;
  else if (std::any_of(frame.prepared.begin(), frame.prepared.end(), sending))
    frame.stats.sending += passed;
  else if (!frame.prepared.empty())
    frame.stats.waiting_for_token += passed;
  else
    frame.stats.idle += passed;
}

/// The same classes as account_time's, with the slice that the time went to.
void Gp::trace_time(double begin, double end, bool computed) {
  if (computed) {
    trace_->add(Activity::slice, piece_.frame, piece_.step, begin, end, piece_.stages);
    return;
  }
  const Frame& frame = *frames_.front();
  if (frame.prepared.empty()) return;
  const auto sent = std::find_if(frame.prepared.begin(), frame.prepared.end(),
                                 [](const PreparedSlice& s) { return !s.awaiting_accept.empty(); });
  const bool sending = sent != frame.prepared.end();
  trace_->add(sending ? Activity::send : Activity::wait_for_token, frame.spec.frame,
              sending ? sent->step : frame.prepared.front().step, begin, end);
}

std::string Gp::waiting_for() const {
  for (const auto& frame : frames_) {
    for (const auto& slice : frame->prepared) {
      if (!slice.awaiting_accept.empty())
        return fmt::format("{} waits for Renderer {} to accept step {} of frame {}", to_string(id()),
                           slice.awaiting_accept.begin()->first, slice.step, frame->spec.frame);
      return fmt::format("{} waits for {} token(s) of step {} of frame {} from GP {}", to_string(id()),
                         slice.tokens_left, slice.step, frame->spec.frame,
                         layout_.gp_of_slice(frame->geometry.traversal.slice_at(frame->before(slice.step),
                                                                                frame->geometry.slices)));
    }
    if (frame->steps_done < frame->steps.size())
      return fmt::format("{} has slices of frame {} left to encode", to_string(id()), frame->spec.frame);
    if (!frame->left_behind.empty())
      return fmt::format("{} waits for Renderer {} to accept a payload of frame {}", to_string(id()),
                         frame->left_behind.begin()->first, frame->spec.frame);
  }
  return {};
}

}  // namespace ringsplat
