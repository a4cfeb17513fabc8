#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "protocol/node.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

/// A slice from the time its payloads are made until all its tokens have passed.
struct PreparedSlice {
  int step;
  std::vector<EncodedPart> parts;                ///< by Renderer; sent ones are empty
  int tokens_left;                               ///< tokens that have not yet passed
  std::map<int, std::uint32_t> awaiting_accept;  ///< Renderer → sequence of the payload sent to it
};

/// A GP's part of one frame.
struct Frame {
  Frame(int gp, const Announcement& announcement, int renderers, Engine& engine)
      : number(announcement.frame),
        plan(engine.plan(announcement)),
        drawing(plan.drawing(renderers)),
        encoder(engine.encoder(gp, announcement)),
        shown(encoder->shown()) {
    // With nothing to show, tokens still visit one step: Renderers wait to learn that no payload comes.
    if (shown.empty()) shown.push_back(0);
    for (const int step : shown)
      if (plan.owners[std::size_t(step)] == gp) steps.push_back(step);
    for (int r = 0; r < renderers; ++r) tours.push_back(tour_of(r));
    if (std::ranges::find(drawing, true) != drawing.end()) return;
    // The volume lies beside the picture.
    stats.voxels_outside = encoder->left_out(steps.size());
    steps.clear();
  }

  std::int64_t number;
  FramePlan plan;
  std::vector<bool> drawing;  ///< by Renderer: it draws something, and has a token
  std::unique_ptr<Encoder> encoder;
  std::vector<int> shown;  ///< steps that tokens go through, ascending
  std::vector<int> steps;  ///< those of `shown` that this GP owns
  /// Shown steps through which a token goes, from the first to the last.
  struct Tour {
    int first, last;
  };
  std::vector<Tour> tours;    ///< by Renderer
  std::size_t next_step = 0;  ///< index into `steps` of the next to encode
  bool encoding = false;      ///< steps[next_step] is being encoded
  std::deque<PreparedSlice> prepared;
  /// By step: tokens that came before the slice was ready.
  std::map<int, std::vector<TokenFields>> waiting_tokens;
  /// Renderer and sequence of payloads that their tokens left behind unaccepted.
  std::set<std::pair<int, std::uint32_t>> left_behind;
  std::size_t steps_done = 0;
  bool dropped = false;  ///< slices not yet sent are skipped
  NodeStats stats;

  /// The shown step after `step` to which a Renderer's token goes, if any.
  std::optional<int> after(int step, int renderer) const {
    if (step >= tours[std::size_t(renderer)].last) return std::nullopt;
    return *std::upper_bound(shown.begin(), shown.end(), step);
  }
  /// How many tokens visit a step.
  int visitors(int step) const {
    int tokens = 0;
    for (std::size_t r = 0; r < tours.size(); ++r)
      if (drawing[r] && tours[r].first <= step && step <= tours[r].last) ++tokens;
    return tokens;
  }
  PreparedSlice* find_slice(int step) {
    const auto found = std::ranges::find_if(prepared, [&](const PreparedSlice& s) { return s.step == step; });
    return found == prepared.end() ? nullptr : &*found;
  }
  /// Where a Renderer has nothing to show, its token visits a step nevertheless.
  Tour tour_of(int renderer) const {
    if (plan.shares.empty()) return {shown.front(), shown.back()};
    const FramePlan::Share& share = plan.shares[std::size_t(renderer)];
    const auto first = std::lower_bound(shown.begin(), shown.end(), share.first);
    if (first == shown.end()) return {shown.back(), shown.back()};
    const auto end = std::lower_bound(first + 1, shown.end(), share.end);
    return {*first, *std::prev(end)};
  }
  bool done() const { return steps_done == steps.size() && left_behind.empty(); }
  /// What it waits for, in words; empty when for nothing.
  std::string waiting_for(const std::string& gp) const {
    if (!prepared.empty()) {
      const PreparedSlice& slice = prepared.front();
      if (!slice.awaiting_accept.empty())
        return fmt::format("{} waits for Renderer {} to accept step {} of frame {}", gp,
                           slice.awaiting_accept.begin()->first, slice.step, number);
      // Owner of the shown step before this one, or of the first shown step.
      const auto here = std::lower_bound(shown.begin(), shown.end(), slice.step);
      const int before = here == shown.begin() ? shown.front() : *std::prev(here);
      return fmt::format("{} waits for {} token(s) of step {} of frame {} from GP {}", gp, slice.tokens_left,
                         slice.step, number, plan.owners[std::size_t(before)]);
    }
    if (steps_done < steps.size()) return fmt::format("{} has slices of frame {} left to encode", gp, number);
    if (!left_behind.empty())
      return fmt::format("{} waits for Renderer {} to accept a payload of frame {}", gp,
                         left_behind.begin()->first, number);
    return {};
  }
};

/// Graphics Processor (Neumann 1992, section 3): prepares its slices of a traversal in order, sends a slice's
/// payload to a Renderer when that Renderer's token for the slice is here, and passes the token on once the
/// payload is accepted, or, beyond the paper, at once while the token knows of free slots (`send_ahead`).
///
/// Memory is bounded: at most `look_ahead` slices are prepared at once, and at most slots + 1 payloads are on
/// their way to a Renderer.
class Gp final : public Node {
 public:
  explicit Gp(NodeParts parts) : my_(std::move(parts)), book_(id(), my_.options.trace) {}

  NodeId id() const override { return {Role::gp, my_.index}; }
  void begin_frame(const Announcement& announcement) override {
    frames_.push_back(std::make_unique<Frame>(my_.index, announcement, my_.layout.renderers, my_.engine));
    start_tokens(*frames_.back());
    finish_completed_frames();
  }

  void drop_frame(std::int64_t number) override {
    // Not when this GP's part is over. What is prepared is still sent: later payloads may rely on it.
    if (Frame* frame = find_frame(number)) frame->dropped = true;
  }

  void receive(Message message) override {
    const Header& h = message.header;
    Frame* frame = find_frame(h.frame);
    if (frame == nullptr)
      throw RunError(fmt::format("{} got a {} of frame {} from {} after that frame was over", to_string(id()),
                                 name(h.kind), h.frame, to_string(h.from())));
    if (h.kind == Kind::token) {
      take_token(*frame, h);
    } else if (h.kind == Kind::accept) {
      take_accept(*frame, h);
      frame->encoder->take_news(message.body());
    } else {
      refuse(id(), h);
    }
    finish_completed_frames();
  }

  bool advance() override {
    finish_completed_frames();
    book(waiting());
    const Turn turn = encode_some();
    book(turn.activity ? turn : waiting());
    return turn.activity.has_value();
  }

  bool amid_slice() const override {
    return std::any_of(frames_.begin(), frames_.end(), [](const auto& frame) { return frame->encoding; });
  }
  bool idle() const override { return frames_.empty(); }
  std::string waiting_for() const override {
    for (const auto& frame : frames_)
      if (const std::string what = frame->waiting_for(to_string(id())); !what.empty()) return what;
    return {};
  }

 private:
  /// Tokens start at the owner of the first slice that their Renderers draw, without layers the front slice,
  /// and visit slices in the traversal's order; that order keeps a mesh without layers free of contention
  /// (docs/protocol.md).
  void start_tokens(Frame& frame) {
    for (int k = 0; k < my_.layout.renderers; ++k) {
      const int renderer = frame.plan.ascending ? k : my_.layout.renderers - 1 - k,
                step = frame.tours[std::size_t(renderer)].first;
      if (!frame.drawing[std::size_t(renderer)] || frame.plan.owners[std::size_t(step)] != my_.index)
        continue;
      frame.waiting_tokens[step].push_back(
          {{step, renderer, 0}, credits_of(std::uint32_t(my_.options.slots))});
      ++frame.stats.tokens_issued;
    }
  }

  Frame* find_frame(std::int64_t number) {
    for (const auto& frame : frames_)
      if (frame->number == number) return frame.get();
    return nullptr;
  }

  void take_token(Frame& frame, const Header& h) {
    const auto token = fields_of<TokenFields>(h);
    const TokenPlace& place = token.place;
    if (!std::binary_search(frame.steps.begin(), frame.steps.end(), place.step))
      throw RunError(
          fmt::format("{} got Renderer {}'s token for step {} of frame {}, whose slice is not its own",
                      to_string(id()), place.renderer, place.step, h.frame));
    book_.mark(Moment::take_token, h.frame, place.step, place.renderer);
    if (PreparedSlice* slice = frame.find_slice(place.step))
      use_token(frame, *slice, token);
    else
      frame.waiting_tokens[place.step].push_back(token);
  }

  void use_token(Frame& frame, PreparedSlice& slice, const TokenFields& token) {
    const auto& [place, credits] = token;
    EncodedPart& part = slice.parts[std::size_t(place.renderer)];
    if (part.payload.empty()) {
      pass_token(frame, slice, token);
      return;
    }
    const Header h = make_header(id(), {Role::renderer, place.renderer}, frame.number,
                                 PayloadFields{.place = place, .passes = part.passes});
    frame.stats.splats_sent += part.items;
    frame.stats.payload_bytes_sent += Message::body_size(part.payload);
    ++frame.stats.payloads_sent;
    book_.mark(Moment::send_payload, frame.number, slice.step, place.renderer);
    my_.post(Message(h, std::exchange(part.payload, {})));
    if (credits == 0) {
      slice.awaiting_accept[place.renderer] = place.sequence;
      return;
    }
    frame.left_behind.emplace(place.renderer, place.sequence);
    pass_token(frame, slice, {{place.step, place.renderer, place.sequence + 1}, credits - 1});
  }

  /// In a mesh a token waits for every accept, so that without layers payloads never meet (docs/protocol.md).
  std::uint32_t credits_of(std::uint32_t free_slots) const {
    return my_.layout.routed() ? 0 : std::min(free_slots, std::uint32_t(my_.options.send_ahead));
  }

  void take_accept(Frame& frame, const Header& h) {
    const auto [place, free_slots] = fields_of<AcceptFields>(h);
    if (frame.left_behind.erase({place.renderer, place.sequence}) > 0) return;
    if (PreparedSlice* slice = frame.find_slice(place.step)) {
      const auto sent = slice->awaiting_accept.find(place.renderer);
      if (sent != slice->awaiting_accept.end() && sent->second == place.sequence) {
        slice->awaiting_accept.erase(sent);
        pass_token(frame, *slice, {{place.step, place.renderer, place.sequence + 1}, credits_of(free_slots)});
        return;
      }
    }
    throw RunError(
        fmt::format("{} got an accept from {} for payload {} of step {}, frame {}, which it did not send",
                    to_string(id()), to_string(h.from()), place.sequence, place.step, h.frame));
  }

  void pass_token(Frame& frame, PreparedSlice& slice, TokenFields token) {
    TokenPlace& place = token.place;
    --slice.tokens_left;
    const std::optional<int> next = frame.after(slice.step, place.renderer);
    if (!next) {
      ++frame.stats.tokens_retired;
      my_.post(Message(make_header(id(), {Role::renderer, place.renderer}, frame.number,
                                   FrameEndFields{.payloads = place.sequence})));
      return;
    }
    ++frame.stats.tokens_passed;
    book_.mark(Moment::pass_token, frame.number, *next, place.renderer);
    place.step = *next;
    my_.post(
        Message(make_header(id(), {Role::gp, frame.plan.owners[std::size_t(*next)]}, frame.number, token)));
  }

  /// Encodes a piece of the next slice; idle when there is none, or no room for it.
  Turn encode_some() {
    // The earliest frame with slices left: a later frame's slices never take the room an earlier one needs.
    const auto found =
        std::ranges::find_if(frames_, [](const auto& f) { return f->next_step < f->steps.size(); });
    if (found == frames_.end()) return {};
    Frame& frame = **found;
    Encoder& encoder = *frame.encoder;
    const int step = frame.steps[frame.next_step];
    const Turn worked{Activity::slice, frame.number, step};
    if (encoder.prepare()) return worked;
    if (!frame.encoding) {
      std::size_t prepared = 0;
      for (const auto& one : frames_) prepared += one->prepared.size();
      if (prepared >= std::size_t(my_.options.look_ahead)) return {};
      encoder.begin(step);
      frame.encoding = true;
    }
    if (frame.dropped)
      prepare_slice(frame, {std::vector<EncodedPart>(std::size_t(my_.layout.renderers)), {}});
    else if (encoder.work())
      prepare_slice(frame, encoder.finish());
    return worked;
  }

  void prepare_slice(Frame& frame, EncodedStep&& encoded) {
    frame.encoding = false;
    frame.stats.slices += std::uint64_t(encoded.slices);
    for (const auto& part : encoded.parts) frame.stats.passes += part.passes;
    frame.stats.blocks += encoded.counts.blocks;
    frame.stats.visible_voxels += encoded.counts.visible;
    frame.stats.voxels_outside += encoded.counts.outside;
    const int step = frame.steps[frame.next_step++];
    frame.prepared.push_back({step, std::move(encoded.parts), frame.visitors(step), {}});
    PreparedSlice& slice = frame.prepared.back();
    const auto waiting = frame.waiting_tokens.extract(step);
    if (waiting.empty()) return;
    for (const TokenFields& token : waiting.mapped()) use_token(frame, slice, token);
  }

  void finish_completed_frames() {
    // Slices from the front whose tokens have all passed are done.
    for (const auto& frame : frames_)
      for (auto& prepared = frame->prepared; !prepared.empty() && prepared.front().tokens_left == 0;) {
        prepared.pop_front();
        ++frame->steps_done;
      }
    while (!frames_.empty() && frames_.front()->done()) {
      book(waiting());
      Frame& frame = *frames_.front();
      frame.stats.slice_memory = frame.encoder->slice_memory();
      my_.post(make_report(id(), frame.number, frame.stats));
      frames_.pop_front();
    }
  }

  /// What this node waits for on its oldest frame.
  Turn waiting() const {
    if (frames_.empty() || frames_.front()->prepared.empty()) return {};
    const Frame& frame = *frames_.front();
    const auto sent = std::ranges::find_if(frame.prepared,
                                           [](const auto& slice) { return !slice.awaiting_accept.empty(); });
    if (sent != frame.prepared.end()) return {Activity::send, frame.number, sent->step};
    return {Activity::wait_for_token, frame.number, frame.prepared.front().step};
  }

  /// Books a turn on the oldest frame.
  void book(const Turn& turn) { book_.turn(turn, frames_.empty() ? nullptr : &frames_.front()->stats); }

  NodeParts my_;
  NodeBook book_;
  std::deque<std::unique_ptr<Frame>> frames_;  ///< announced frames whose part here is not over
};

}  // namespace

std::unique_ptr<Node> make_gp(NodeParts parts) { return std::make_unique<Gp>(std::move(parts)); }

}  // namespace ringsplat
