#pragma once
// An engine without voxels: payloads are integers, tiles say which steps were drawn, in which order.
#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "base/byte_stream.hpp"
#include "net/message.hpp"
#include "protocol/engine.hpp"
#include "protocol/frame_source.hpp"
#include "protocol/node.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::test {

/// A toy frame's description, the body of its announcement.
struct ToyFrame {
  int steps = 6;
  int gps = 2, renderers = 1;
  int tiles = 1;  ///< dealt to the Renderers in turn
  bool ascending = true;
  std::uint64_t hidden_steps = 0;    ///< bit s: no token goes through step s
  std::uint64_t empty_payloads = 0;  ///< bit s: step s has empty payloads
  std::uint32_t lost_items = 0;      ///< how many more items encoders report than they send
  int prepare_pieces = 0;            ///< pieces of work before the first step
  int spare_pieces = 0;              ///< pieces of work that a painter does while it waits
  int bundle = 1;                    ///< slices that a GP gets together
  int first_slice = 0;               ///< in the volume, of which the frame shows a part
  int layer = 0;                     ///< steps of a layer, one for each Renderer; 0: there are none

  /// The slice of a step, in the volume.
  int slice(int step) const { return first_slice + (ascending ? step : steps - 1 - step); }
  bool shows(int step) const { return (hidden_steps >> step & 1) == 0; }
  bool has_payload(int step) const { return shows(step) && (empty_payloads >> step & 1) == 0; }
};

inline Bytes body_of(const ToyFrame& frame) {
  Bytes body;
  append(body, frame);
  return body;
}

inline ToyFrame toy_frame(const Announcement& announcement) {
  ToyFrame frame;
  std::size_t at = 0;
  if (!take(announcement.body, at, frame)) throw RunError("no toy frame");
  return frame;
}

/// A payload's content: its frame and step.
struct ToyItem {
  std::int64_t frame;
  int step;
};

class ToyEncoder final : public Encoder {
 public:
  explicit ToyEncoder(const Announcement& a)
      : number_(a.frame), frame_(toy_frame(a)), to_prepare_(frame_.prepare_pieces) {}

  std::vector<int> shown() override {
    std::vector<int> steps;
    for (int step = 0; step < frame_.steps; ++step)
      if (frame_.shows(step)) steps.push_back(step);
    return steps;
  }
  std::uint64_t left_out(std::size_t steps) const override { return steps; }
  bool prepare() override { return to_prepare_-- > 0; }
  void begin(int step) override { step_ = step; }
  bool work() override { return true; }
  EncodedStep finish() override {
    EncodedStep step;
    step.parts.resize(std::size_t(frame_.renderers));
    step.counts = {1, 1, 0};
    for (auto& part : step.parts) {
      if (!frame_.has_payload(step_)) continue;
      part.payload = Message::body_buffer();
      append(part.payload, ToyItem{number_, step_});
      part.items = 1 + frame_.lost_items;
      part.passes = 1;
    }
    return step;
  }
  void take_news(std::span<const std::byte> news) override { news_taken += news.size(); }
  std::uint64_t slice_memory() const override { return 0; }

  std::size_t news_taken = 0;

 private:
  std::int64_t number_;
  ToyFrame frame_;
  int to_prepare_;
  int step_ = 0;
};

class ToyPainter final : public Painter {
 public:
  ToyPainter(int renderer, const Announcement& a)
      : renderer_(renderer), number_(a.frame), frame_(toy_frame(a)), to_do_(frame_.spare_pieces) {}

  /// Writes −2 among the steps.
  bool prepare() override {
    if (to_do_ == 0) return false;
    --to_do_;
    steps.push_back(-2);
    return true;
  }
  void begin(const PayloadToDraw& payload) override {
    ToyItem item{};
    std::size_t at = 0;
    if (!take(payload.body, at, item) || item.frame != number_ || item.step != payload.step)
      throw RunError("no toy payload of this frame and step");
    steps.push_back(payload.step);
  }
  bool work() override { return true; }
  void news(int gp, Bytes& news) override {
    if (news.empty()) news = Message::body_buffer();
    append(news, gp);
  }
  ItemCounts counts() const override { return {.drawn = steps.size()}; }
  /// The steps drawn.
  Bytes hand_over(int) override {
    Bytes bytes = Message::body_buffer();
    for (const int step : steps) append(bytes, step);
    return bytes;
  }
  void gather(int from, std::span<const std::byte> bytes) override { gathered[from] = bytes.size(); }
  /// A tile is the list of drawn steps, padded with −1.
  void finish(const std::function<void(int, Bytes)>& deliver) override {
    for (int tile = renderer_; tile < frame_.tiles; tile += frame_.renderers) {
      std::vector<int> all = steps;
      all.resize(std::size_t(frame_.steps), -1);
      Bytes bytes = Message::body_buffer();
      for (const int step : all) append(bytes, step);
      deliver(tile, std::move(bytes));
    }
  }

  std::vector<int> steps;               ///< steps drawn, in order
  std::map<int, std::size_t> gathered;  ///< by Renderer: bytes that it handed over

 private:
  int renderer_;
  std::int64_t number_;
  ToyFrame frame_;
  int to_do_;
};

/// The tiles that came for a frame, as lists of steps.
using ToyPicture = std::map<int, std::vector<int>>;

class ToyEngine final : public Engine {
 public:
  FramePlan plan(const Announcement& a) override {
    const ToyFrame frame = toy_frame(a);
    FramePlan plan;
    plan.ascending = frame.ascending;
    for (int step = 0; step < frame.steps; ++step)
      plan.owners.push_back(frame.slice(step) / frame.bundle % frame.gps);
    plan.first_slice = frame.slice(0);
    for (int tile = 0; tile < frame.tiles; ++tile)
      plan.tiles.push_back({tile % frame.renderers, std::size_t(frame.steps) * sizeof(int)});
    for (int r = 0; r < frame.renderers && frame.layer > 0; ++r) {
      FramePlan::Share& share = plan.shares.emplace_back();
      share = {std::min(r * frame.layer, frame.steps), std::min((r + 1) * frame.layer, frame.steps)};
      for (int taker = 0; taker < std::min(frame.tiles, frame.renderers); ++taker)
        share.takers.push_back(taker);
    }
    return plan;
  }
  std::unique_ptr<Encoder> encoder(int, const Announcement& a) override {
    auto made = std::make_unique<ToyEncoder>(a);
    encoders[a.frame] = made.get();
    return made;
  }
  std::shared_ptr<Painter> painter(int renderer, const Announcement& a) override {
    return painter_ = std::make_shared<ToyPainter>(renderer, a);
  }
  std::unique_ptr<Canvas> canvas(const Announcement& a) override {
    class ToyCanvas final : public Canvas {
     public:
      ToyCanvas(ToyPicture& picture, bool& finished) : picture_(picture), finished_(finished) {}
      void take(int tile, std::span<const std::byte> bytes) override {
        std::vector<int>& steps = picture_[tile];
        steps.resize(bytes.size() / sizeof(int));
        std::memcpy(steps.data(), bytes.data(), bytes.size());
      }
      void finish() override { finished_ = true; }

     private:
      ToyPicture& picture_;
      bool& finished_;
    };
    return std::make_unique<ToyCanvas>(pictures[a.frame], finished[a.frame]);
  }

  ToyPainter& painter() { return *painter_; }

  std::map<std::int64_t, ToyEncoder*> encoders;  ///< by frame; valid while their frames are under way
  std::map<std::int64_t, ToyPicture> pictures;   ///< by frame
  std::map<std::int64_t, bool> finished;

 private:
  std::shared_ptr<ToyPainter> painter_;
};

/// Frames from a list.
class ToyFrames final : public FrameSource {
 public:
  explicit ToyFrames(std::vector<ToyFrame> list) : list_(std::move(list)) {}
  std::optional<Bytes> next(std::int64_t frame) override {
    if (std::size_t(frame) >= list_.size()) return std::nullopt;
    return body_of(list_[std::size_t(frame)]);
  }
  bool may_come() override { return false; }
  bool unwanted(std::int64_t frame) override {
    return std::find(to_drop.begin(), to_drop.end(), frame) != to_drop.end();
  }
  void done(FrameStats&& stats) override { over.push_back(std::move(stats)); }

  std::vector<std::int64_t> to_drop;
  std::vector<FrameStats> over;

 private:
  std::vector<ToyFrame> list_;
};

/// Keeps the messages that a lone node posts.
struct Posted {
  std::vector<Message> messages;
  Post post() {
    return [this](Message m) { messages.push_back(std::move(m)); };
  }
  /// Removes and returns the messages of a kind.
  std::vector<Message> take(Kind kind) {
    std::vector<Message> some, rest;
    for (Message& m : messages) (m.header.kind == kind ? some : rest).push_back(std::move(m));
    messages = std::move(rest);
    return some;
  }
};

inline Announcement announcement(std::int64_t number, const ToyFrame& frame) {
  return {number, body_of(frame)};
}

/// Lets a node work until it has nothing to do.
template <class SomeNode>
void run(SomeNode& node) {
  for (int turn = 0; turn < 10000 && node.advance(); ++turn) {
  }
}

}  // namespace ringsplat::test
