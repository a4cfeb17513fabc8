// What a node does with messages, one by one, and that it refuses those that no node should send it.
#include <fmt/format.h>

#include <array>
#include <chrono>
#include <thread>

#include "node/nodes.hpp"
#include "node/views.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/node/frame_buffer.hpp"
#include "ringsplat/node/gp.hpp"
#include "ringsplat/node/renderer.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::test;
using Catch::Matchers::Contains;

namespace {

const Grid grid = make_grid({9, 9, 9});

/// Every slice has something for every Renderer.
FrameSpec solid() {
  FrameSpec spec = oblique_view(48, 48, 16);
  spec.transfer_function = constant_opacity(0.5);
  return spec;
}

int count(const std::vector<Message>& messages, Kind kind) {
  return int(std::count_if(messages.begin(), messages.end(),
                           [kind](const Message& m) { return m.header.kind == kind; }));
}

/// The GP of two that does not begin, its one Renderer and the other GP being played by the test.
class SecondGp {
 public:
  explicit SecondGp(const ProtocolOptions& protocol) {
    const Layout layout{2, 1};
    const FrameGeometry geometry = make_geometry(spec_, grid);
    const auto owner = [&](int step) {
      return layout.gp_of_slice(geometry.traversal.slice_at(step, geometry.slices));
    };
    index_ = 1 - owner(0);
    for (int step = 0; step < geometry.slices; ++step)
      if (owner(step) == index_) steps_.push_back(step);
    const auto source = synth_source("constant", grid);
    auto stores = dealt(*source, layout.gps);
    gp_.emplace(index_, layout, protocol, std::move(stores.at(index_)),
                [this](Message m) { posted.push_back(std::move(m)); });
    spec_.dealt_to = layout.renderers;
    gp_->begin_frame(spec_);
  }

  Gp& gp() { return *gp_; }
  void work() {
    while (gp_->advance()) {
    }
  }
  /// Its k-th step.
  int step(std::size_t k) const { return steps_.at(k); }
  std::size_t steps() const { return steps_.size(); }
  void token(int step, std::uint32_t sequence, std::uint32_t credits) {
    gp_->receive(Message({.kind = Kind::token,
                          .source_role = Role::gp,
                          .destination_role = Role::gp,
                          .source = 1 - index_,
                          .destination = index_,
                          .step = step,
                          .sequence = sequence,
                          .region = credits}));
  }
  void accept(int step, std::uint32_t sequence, int renderer = 0) {
    gp_->receive(Message({.kind = Kind::accept,
                          .source_role = Role::renderer,
                          .destination_role = Role::gp,
                          .source = renderer,
                          .destination = index_,
                          .step = step,
                          .renderer = renderer,
                          .sequence = sequence}));
  }
  std::vector<Message> posted;

 private:
  FrameSpec spec_ = solid();
  int index_ = 0;
  std::vector<int> steps_;
  std::optional<Gp> gp_;
};

/// The only Renderer, to which the test sends payloads that are never looked into.
class OneRenderer {
 public:
  explicit OneRenderer(int slots)
      : renderer(0, Layout{1, 1}, {.slots = slots}, grid,
                 [this](Message m) { posted.push_back(std::move(m)); }) {
    renderer.begin_frame(solid());
    renderer.drop_frame(0);
  }
  void payload(std::uint32_t sequence) {
    Bytes body = Message::body_buffer();
    append(body, sequence);
    send(Kind::payload, sequence, std::move(body));
  }
  void send(Kind kind, std::uint32_t sequence, Bytes body = {}) {
    renderer.receive(Message({.kind = kind,
                              .source_role = Role::gp,
                              .destination_role = Role::renderer,
                              .step = int(sequence),
                              .sequence = sequence},
                             std::move(body)));
  }
  std::vector<Message> posted;
  Renderer renderer;
};

/// The frame buffer of one GP and two Renderers, which the test plays.
class Desk {
 public:
  explicit Desk(int frames, int in_flight = 1)
      : buffer(layout, {.frames_in_flight = in_flight}, grid, director(frames),
               [this](Message m) { announced.push_back(std::move(m)); }) {}

  /// Lets it do all that it can.
  void work() {
    while (buffer.advance()) {
    }
  }
  FrameGeometry geometry() const {
    return make_geometry(decode_frame_spec(announced.at(0).body()), grid);
  }
  int owner(int region) const { return geometry().owners(layout.renderers).of(region); }
  /// The regions that Renderers have.
  std::vector<int> regions() const {
    std::vector<int> dealt;
    for (int region = 0; region < geometry().regions.count(); ++region)
      if (owner(region) != RegionOwners::nobody) dealt.push_back(region);
    return dealt;
  }
  void tile(int region, int renderer, float value = 0.5F, int pixels_too_many = 0, std::int64_t frame = 0) {
    Bytes body = Message::body_buffer();
    const PixelRect rect = geometry().regions.rect(std::min(region, geometry().regions.count() - 1));
    for (int k = 0; k < 4 * (rect.width() * rect.height() + pixels_too_many); ++k) append(body, value);
    Header h{.kind = Kind::tile,
             .source_role = Role::renderer,
             .destination_role = Role::frame_buffer,
             .source = renderer,
             .frame = frame};
    h.region = std::uint32_t(region);
    buffer.receive(Message(h, std::move(body)));
  }
  void report(NodeId node, const NodeStats& stats = {}, std::int64_t frame = 0, int bytes_missing = 0) {
    Bytes body = Message::body_buffer();
    append(body, stats);
    body.resize(body.size() - std::size_t(bytes_missing));
    buffer.receive(Message({.kind = Kind::report,
                            .source_role = node.role,
                            .destination_role = Role::frame_buffer,
                            .source = node.index,
                            .frame = frame},
                           std::move(body)));
  }
  void report_all(const NodeStats& gp, const NodeStats& first_renderer, std::int64_t frame = 0) {
    report({Role::gp, 0}, gp, frame);
    report({Role::renderer, 0}, first_renderer, frame);
    report({Role::renderer, 1}, {}, frame);
  }

  const Layout layout{1, 2};
  std::vector<Message> announced;
  std::vector<FrameResult> done;
  FrameBuffer buffer;

 private:
  Director director(int frames) {
    return {[this, frames]() -> std::optional<FrameSpec> {
              return asked_++ < frames ? std::optional(solid()) : std::nullopt;
            },
            [this](FrameResult&& result) { done.push_back(std::move(result)); }};
  }
  int asked_ = 0;
};

}  // namespace

TEST_CASE("a GP prepares as many slices as it may look ahead, and no more") {
  for (const int look_ahead : {1, 2, 3}) {
    SecondGp one({.slots = 20, .look_ahead = look_ahead, .send_ahead = 20});
    one.work();
    // Of slices that are ready the payload leaves with the token's arrival.
    for (std::size_t k = 0; k < one.steps(); ++k) one.token(one.step(k), std::uint32_t(k), 20);
    CHECK(count(one.posted, Kind::payload) == look_ahead);
    one.work();
    CHECK(count(one.posted, Kind::payload) == int(one.steps()));
  }
}

TEST_CASE("what a GP has prepared of a dropped frame stays there, and its tokens go on") {
  SecondGp one({.look_ahead = 2});
  one.work();
  one.gp().drop_frame(0);
  for (std::size_t k = 0; k < one.steps(); ++k) {
    one.token(one.step(k), 0, 0);
    one.work();
  }
  CHECK(count(one.posted, Kind::payload) == 0);
  CHECK(count(one.posted, Kind::token) + count(one.posted, Kind::frame_end) == int(one.steps()));
  CHECK(count(one.posted, Kind::report) == 1);
}

TEST_CASE("a GP refuses tokens and accepts that are not for it") {
  SecondGp one({});
  one.work();
  CHECK_THROWS_WITH(one.token(one.step(0) - 1, 0, 0), Contains("not its own"));
  CHECK_THROWS_WITH(one.token(1000, 0, 0), Contains("not its own"));
  CHECK_THROWS_WITH(one.accept(one.step(0), 0), Contains("which it did not send"));
  one.token(one.step(0), 3, 0);
  REQUIRE(count(one.posted, Kind::payload) == 1);
  CHECK_THROWS_WITH(one.accept(one.step(0), 2), Contains("which it did not send"));
  CHECK_THROWS_WITH(one.accept(one.step(1), 3), Contains("which it did not send"));
  CHECK_THROWS_WITH(one.accept(one.step(0), 3, 1), Contains("which it did not send"));
  CHECK(count(one.posted, Kind::token) == 0);
  one.accept(one.step(0), 3);
  REQUIRE(count(one.posted, Kind::token) == 1);
  CHECK(one.posted.back().header.sequence == 4);
  CHECK_THROWS_WITH(one.accept(one.step(0), 3), Contains("which it did not send"));
  CHECK_THROWS_WITH(
      one.gp().receive(Message({.kind = Kind::frame_end, .source_role = Role::gp, .source = 1})),
      Contains("cannot use a frame end"));
}

TEST_CASE("a GP has done its part when the payloads it left behind are accepted as well") {
  SecondGp one({.slots = 20, .look_ahead = 20, .send_ahead = 20});
  one.work();
  for (std::size_t k = 0; k < one.steps(); ++k) one.token(one.step(k), std::uint32_t(k), 20);
  one.work();
  for (std::size_t k = 0; k < one.steps(); ++k) {
    CHECK(count(one.posted, Kind::report) == 0);
    CHECK_THAT(one.gp().waiting_for(), Contains("waits for Renderer 0 to accept"));
    one.accept(one.step(k), std::uint32_t(k));
    one.work();
  }
  CHECK(count(one.posted, Kind::report) == 1);
  CHECK(one.gp().waiting_for().empty());
  CHECK_THROWS_WITH(one.token(one.step(0), 0, 0), Contains("after that frame was over"));
}

TEST_CASE("a Renderer accepts as many payloads as it has slots, in the order of their numbers") {
  OneRenderer one(2);
  for (const std::uint32_t sequence : {1U, 2U, 0U}) one.payload(sequence);
  // Number 2 waits; the others say how many slots are left behind them.
  REQUIRE(one.posted.size() == 2);
  for (const Message& accept : one.posted) {
    CHECK(accept.header.kind == Kind::accept);
    CHECK(accept.header.region == 1 - accept.header.sequence);
    CHECK(accept.header.to() == NodeId{Role::gp, 0});
  }
  CHECK_THROWS_WITH(one.payload(3), Contains("while it had slots for those before 2"));
  REQUIRE(one.renderer.advance());
  REQUIRE(one.posted.size() == 3);
  CHECK(one.posted.back().header.sequence == 2);
}

TEST_CASE("a Renderer refuses a payload that it had, and to be told twice that a frame is complete") {
  OneRenderer one(2);
  one.payload(0);
  CHECK_THROWS_WITH(one.payload(0), Contains("payload 0 of frame 0 twice"));
  REQUIRE(one.renderer.advance());
  CHECK_THROWS_WITH(one.payload(0), Contains("payload 0 of frame 0 twice"));  // drawn meanwhile
  CHECK_THROWS_WITH(one.send(Kind::token, 1), Contains("cannot use a token"));
  one.send(Kind::frame_end, 2);
  CHECK_THROWS_WITH(one.send(Kind::frame_end, 2), Contains("twice"));
  one.payload(1);
  while (one.renderer.advance()) {
  }
  CHECK(count(one.posted, Kind::report) == 1);
  CHECK_THROWS_WITH(one.payload(2), Contains("after that frame was delivered"));
}

TEST_CASE("the frame buffer refuses tiles that are not their sender's, came before or have another size") {
  Desk desk(1);
  desk.work();
  const auto regions = desk.regions();
  REQUIRE(regions.size() > 2);
  const int region = regions[0], owner = desk.owner(region);
  CHECK_THROWS_WITH(desk.tile(region, 1 - owner), Contains("not its own"));
  CHECK_THROWS_WITH(desk.tile(desk.geometry().regions.count(), owner), Contains("not its own"));
  CHECK_THROWS_WITH(desk.tile(region, owner, 0.5F, 1), Contains("bytes for region"));
  CHECK_THROWS_WITH(desk.tile(region, owner, 0.5F, -1), Contains("bytes for region"));
  CHECK_THROWS_WITH(desk.tile(region, owner, 0.5F, 0, 1), Contains("not being rendered"));
  desk.tile(region, owner);
  CHECK_THROWS_WITH(desk.tile(region, owner), Contains("came before"));
}

TEST_CASE("a frame is complete when all have reported and the tiles that they report are here") {
  Desk desk(1);
  desk.work();
  const int region = desk.regions().at(0), owner = desk.owner(region);
  NodeStats with_tile;
  with_tile.tiles = 1;
  desk.report({Role::gp, 0});
  CHECK_THROWS_WITH(desk.report({Role::gp, 0}), Contains("twice"));
  CHECK_THROWS_WITH(desk.report({Role::renderer, owner}, with_tile, 0, 1), Contains("report of"));
  desk.report({Role::renderer, owner}, with_tile);
  CHECK_THROWS_WITH(desk.report({Role::renderer, owner}, with_tile), Contains("twice"));
  desk.work();
  CHECK(desk.done.empty());
  CHECK_THAT(desk.buffer.waiting_for(), Contains(fmt::format("Renderer {}", 1 - owner)));
  desk.report({Role::renderer, 1 - owner});
  desk.work();
  CHECK(desk.done.empty());
  CHECK_THAT(desk.buffer.waiting_for(), Contains("1 tile(s)"));
  desk.tile(region, owner);
  desk.work();
  CHECK(desk.done.size() == 1);
  CHECK(desk.announced.back().header.kind == Kind::shutdown);
}

TEST_CASE("a frame whose sums do not add up ends the run") {
  NodeStats gp, renderer;
  gp.splats_sent = 6;
  renderer.splats_drawn = 3;
  renderer.splats_clipped = 2;
  renderer.splats_hidden = 1;
  gp.tokens_issued = gp.tokens_retired = 2;
  gp.payload_bytes_sent = renderer.payload_bytes_received = 100;
  const auto ends_with = [](const NodeStats& g, const NodeStats& r) -> std::string {
    Desk desk(1);
    desk.work();
    desk.report_all(g, r);
    try {
      desk.work();
    } catch (const RunError& e) {
      return e.what();
    }
    return desk.done.size() == 1 ? "done" : "waits";
  };
  REQUIRE(ends_with(gp, renderer) == "done");
  for (const int by : {-1, 1}) {
    const auto changed = [by](NodeStats stats, std::uint64_t NodeStats::*part) {
      stats.*part += std::uint64_t(by);
      return stats;
    };
    CHECK_THAT(ends_with(changed(gp, &NodeStats::splats_sent), renderer), Contains("splats sent"));
    for (const auto part :
         {&NodeStats::splats_drawn, &NodeStats::splats_clipped, &NodeStats::splats_hidden})
      CHECK_THAT(ends_with(gp, changed(renderer, part)), Contains("splats sent"));
    CHECK_THAT(ends_with(changed(gp, &NodeStats::tokens_issued), renderer), Contains("tokens issued"));
    CHECK_THAT(ends_with(changed(gp, &NodeStats::payload_bytes_sent), renderer), Contains("bytes sent"));
  }
}

TEST_CASE("pixels for which no tile comes are empty, whatever their memory held") {
  Desk desk(8);
  for (int frame = 0; frame < 8; ++frame) {
    desk.work();
    const auto regions = desk.regions();
    // All tiles, which leaves their values in the memory that comes free, and then a single one.
    const std::size_t tiles = frame % 2 == 0 ? regions.size() : 1;
    std::array<NodeStats, 2> renderers;
    for (std::size_t k = 0; k < tiles; ++k) {
      const int owner = desk.owner(regions[k]);
      desk.tile(regions[k], owner, 7.0F, 0, frame);
      ++renderers[std::size_t(owner)].tiles;
    }
    desk.report({Role::gp, 0}, {}, frame);
    for (int r = 0; r < 2; ++r) desk.report({Role::renderer, r}, renderers[std::size_t(r)], frame);
    desk.work();
    REQUIRE(desk.done.size() == 1);
    const Image image = std::move(desk.done.front().image);
    desk.done.clear();
    float sum = 0, expected = 0;
    for (const float value : image.rgba) sum += value;
    for (std::size_t k = 0; k < tiles; ++k) {
      const PixelRect rect = desk.geometry().regions.rect(regions[k]);
      expected += 7.0F * 4 * float(rect.width() * rect.height());
    }
    CHECK(sum == expected);
  }
}

TEST_CASE("no more frames are announced than may be in flight, and periods do not overlap") {
  for (const int in_flight : {1, 2, 3}) {
    Desk desk(4, in_flight);
    desk.work();
    CHECK(count(desk.announced, Kind::frame_spec) == in_flight);
    for (int frame = 0; frame < 4; ++frame) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      desk.report_all({}, {}, frame);
      desk.work();
      CHECK(count(desk.announced, Kind::frame_spec) == std::min(4, in_flight + frame + 1));
      const FrameStats& stats = desk.done.at(std::size_t(frame)).stats;
      // The frame before was complete when this one was announced already, or earlier.
      if (in_flight == 1 || frame == 0)
        CHECK(stats.period == stats.seconds);
      else
        CHECK(stats.period < stats.seconds);
    }
  }
}
