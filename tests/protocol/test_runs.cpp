#include <fmt/format.h>

#include <set>

#include "protocol/bundle_engine.hpp"
#include "protocol/rank.hpp"
#include "support/catch.hpp"
#include "toy_engine.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

struct ToyRun {
  std::vector<FrameStats> over;
  std::map<std::int64_t, ToyPicture> pictures;
};

ToyRun run_all(const Layout& layout, const ProtocolOptions& options, const std::vector<ToyFrame>& frames,
               const LoopbackOptions& loopback, const std::vector<std::int64_t>& to_drop = {}) {
  ToyFrames source(frames);
  source.to_drop = to_drop;
  ToyEngine* at_frame_buffer = nullptr;
  ToyRun done;
  const auto make_engine = [&](int rank) -> std::unique_ptr<Engine> {
    auto engine = std::make_unique<ToyEngine>();
    if (rank == 0) at_frame_buffer = engine.get();
    if (layout.bundle == 1) return engine;
    return make_bundle_engine(std::move(engine), layout.bundle);
  };
  // Copies pictures before the engines end with the run.
  class Keeping final : public FrameSource {
   public:
    Keeping(ToyFrames& frames, ToyEngine*& engine, ToyRun& run)
        : frames_(frames), engine_(engine), run_(run) {}
    std::optional<Bytes> next(std::int64_t frame) override { return frames_.next(frame); }
    bool may_come() override { return false; }
    bool unwanted(std::int64_t frame) override { return frames_.unwanted(frame); }
    void done(FrameStats&& stats) override {
      run_.pictures[stats.frame] = engine_->pictures[stats.frame];
      run_.over.push_back(std::move(stats));
    }

   private:
    ToyFrames& frames_;
    ToyEngine*& engine_;
    ToyRun& run_;
  } keeping(source, at_frame_buffer, done);
  run_loopback(layout, options, make_engine, keeping, loopback);
  return done;
}

/// The steps whose payloads a Renderer must draw, padded with −1 like tiles.
std::vector<int> expected_tile(const ToyFrame& frame) {
  std::vector<int> steps;
  for (int step = 0; step < frame.steps; ++step)
    if (frame.has_payload(step)) steps.push_back(step);
  steps.resize(std::size_t(frame.steps), -1);
  return steps;
}

std::vector<Layout> layouts() {
  return {{1, 1},
          {2, 1},
          {3, 2},
          {2, 5},
          {4, 4, Placement::colocated},
          {1, 3, Placement::colocated},
          mesh_layout(2, 2, 2),
          mesh_layout(3, 3, 6),
          mesh_layout(2, 3, 3, Routing::direct)};
}

}  // namespace

TEST_CASE(
    "every Renderer draws every slice once and in order, by one payload and one token for each bundle, on "
    "any "
    "layout, whatever order messages come in") {
  for (Layout layout : layouts())
    for (std::uint64_t seed = 0; seed < 80; ++seed) {
      layout.bundle = seed < 40 ? 1 : std::array{2, 3, 7, 1000}[seed % 4];
      std::vector<ToyFrame> frames;
      for (int k = 0; k < 5; ++k)
        frames.push_back({.steps = 1 + int((seed + 3 * std::uint64_t(k)) % 17),
                          .gps = layout.gps,
                          .renderers = layout.renderers,
                          .tiles = int((seed + std::uint64_t(k)) % 4) * layout.renderers / 2,
                          .ascending = (seed + std::uint64_t(k)) % 2 == 0,
                          .hidden_steps = layout.routed() ? 0 : seed * 0x9e3779b97f4a7c15 >> (46 - k),
                          .empty_payloads = seed * 0xbf58476d1ce4e5b9 >> (44 + k),
                          .bundle = layout.bundle,
                          .first_slice = int(seed % 5)});
      const ProtocolOptions options{.frames_in_flight = 1 + int(seed % 3),
                                    .slots = 1 + int(seed % 4),
                                    .link_slots = 1 + int(seed % 2),
                                    .look_ahead = 1 + int(seed % 3),
                                    .send_ahead = int(seed % 5)};
      INFO(fmt::format("{} GPs, {} Renderers, bundles of {}, seed {}", layout.gps, layout.renderers,
                       layout.bundle, seed));
      const ToyRun done =
          run_all(layout, options, frames, {.seed = seed, .reorder = true, .max_delay = int(seed % 7)});
      REQUIRE(done.over.size() == frames.size());
      for (std::size_t k = 0; k < frames.size(); ++k) {
        const ToyFrame& frame = frames[k];
        std::set<int> shown, sent;
        int slices = 0;
        for (int step = 0; step < frame.steps; ++step) {
          if (frame.shows(step)) shown.insert(frame.slice(step) / layout.bundle);
          if (frame.has_payload(step)) sent.insert(frame.slice(step) / layout.bundle);
          slices += frame.shows(step);
        }
        const ToyPicture& picture = done.pictures.at(std::int64_t(k));
        REQUIRE(picture.size() == std::size_t(frame.tiles));
        for (const auto& [tile, steps] : picture) REQUIRE(steps == expected_tile(frame));
        const FrameStats& stats = done.over[k];
        REQUIRE(stats.frame == std::int64_t(k));
        const NodeStats sum = stats.total();
        const auto drawing = std::uint64_t(std::min(frame.tiles, layout.renderers));
        REQUIRE(stats.slices == frame.steps);
        REQUIRE(sum.tokens_issued == drawing);
        REQUIRE(sum.tokens_retired == drawing);
        REQUIRE(sum.tokens_passed == drawing * (std::max<std::size_t>(1, shown.size()) - 1));
        REQUIRE(sum.payloads_sent == drawing * sent.size());
        REQUIRE(sum.payloads_drawn == sum.payloads_sent);
        if (drawing > 0) REQUIRE(sum.slices == std::uint64_t(std::max(1, slices)));
        if (drawing == 0) REQUIRE(sum.voxels_outside == std::uint64_t(std::max(1, slices)));
      }
    }
}

TEST_CASE("dropped frames end wherever they are, and the frames between them are whole") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Layout layout = seed % 3 == 0 ? mesh_layout(2, 2, 2) : Layout{3, 2};
    layout.bundle = seed < 40 ? 1 : 2;
    const ToyFrame frame{
        .steps = 7, .gps = layout.gps, .renderers = layout.renderers, .tiles = 4, .bundle = layout.bundle};
    const std::vector<ToyFrame> frames(6, frame);
    const ToyRun done = run_all(layout, {.frames_in_flight = 2, .slots = 1, .send_ahead = int(seed % 3)},
                                frames, {.seed = seed, .reorder = true, .max_delay = int(seed % 9)}, {1, 4});
    REQUIRE(done.over.size() == 6);
    for (const FrameStats& stats : done.over) {
      REQUIRE(stats.dropped == (stats.frame == 1 || stats.frame == 4));
      if (stats.dropped) continue;
      REQUIRE(done.pictures.at(stats.frame).size() == 4);
      for (const auto& [tile, steps] : done.pictures.at(stats.frame))
        REQUIRE(steps == expected_tile(frames[0]));
    }
  }
}

TEST_CASE("an encoder that loses items is found out at the frame's end") {
  const ToyFrame lossy{.steps = 4, .gps = 2, .renderers = 1, .lost_items = 1};
  CHECK_THROWS_WITH(run_all({2, 1}, {}, {lossy}, {}),
                    Catch::Matchers::Contains("8 splats sent, but 4 drawn"));
}

TEST_CASE("what is called between turns may end the run") {
  int calls = 0;
  LoopbackOptions loopback;
  loopback.poll = [&calls] {
    if (++calls == 5) throw std::runtime_error("enough");
  };
  CHECK_THROWS_WITH(run_all({.gps = 2, .renderers = 2}, {}, {ToyFrame{}}, loopback), "enough");
  CHECK(calls == 5);
}

TEST_CASE("a rank that hears nothing any more ends the run with a report of who waits for whom") {
  class Deaf final : public TransportDecorator {
   public:
    using TransportDecorator::TransportDecorator;
    void send(int destination, Message message) override { inner_.send(destination, std::move(message)); }
    std::optional<Message> receive() override {
      return rank() == 1 && heard_ == 3 ? std::nullopt : (++heard_, inner_.receive());
    }

   private:
    int heard_ = 0;
  };
  LoopbackOptions loopback;
  loopback.between.pace = [](Transport& links) { return std::make_unique<Deaf>(links); };
  const ToyFrame frame{.steps = 6, .gps = 2, .renderers = 1};
  CHECK_THROWS_WITH(
      run_all({2, 1}, {.slots = 1}, {frame}, loopback),
      Catch::Matchers::Contains("no rank can move") &&
          Catch::Matchers::Contains("rank 1: GP 1 waits for 1 token(s) of step 1 of frame 0 from GP 0"));
}
