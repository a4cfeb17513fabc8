#include <chrono>
#include <thread>

#include "base/byte_stream.hpp"
#include "support/catch.hpp"
#include "toy_engine.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr NodeId gp_0{Role::gp, 0}, gp_1{Role::gp, 1}, renderer_0{Role::renderer, 0};

/// A frame buffer alone: two GPs, one Renderer with two tiles.
struct LoneFrameBuffer {
  explicit LoneFrameBuffer(int frames = 1, const ProtocolOptions& options = {},
                           Layout layout = {.gps = 2, .renderers = 1})
      : source(std::vector<ToyFrame>(std::size_t(frames), ToyFrame{.steps = 3, .tiles = 2})),
        made(make_frame_buffer({0, layout, options, engine, posted.post()}, source)) {
    run(buffer);
  }

  void give_tile(std::int64_t frame, int tile, NodeId from = renderer_0,
                 std::size_t bytes = 3 * sizeof(int)) {
    Bytes body = Message::body_buffer();
    body.resize(body.size() + bytes, std::byte{1});
    buffer.receive(
        Message(make_header(from, frame_buffer_id, frame, TileFields{.tile = tile}), std::move(body)));
    run(buffer);
  }
  void report(std::int64_t frame, NodeId from, const NodeStats& stats) {
    Bytes body = Message::body_buffer();
    append(body, stats);
    buffer.receive(Message(make_header(Kind::report, from, frame_buffer_id, frame), std::move(body)));
    run(buffer);
  }
  /// Delivers a whole frame with correct sums.
  void finish(std::int64_t frame) {
    report(frame, gp_0, sent);
    report(frame, gp_1, {});
    give_tile(frame, 0);
    report(frame, renderer_0, drawn);
  }
  std::vector<std::int64_t> announced(Kind kind) {
    std::vector<std::int64_t> frames;
    for (const Message& m : posted.take(kind)) frames.push_back(m.header.frame);
    return frames;
  }

  NodeStats sent{.splats_sent = 5, .payload_bytes_sent = 9, .tokens_issued = 1, .tokens_retired = 1};
  NodeStats drawn{
      .splats_drawn = 2, .splats_clipped = 2, .splats_hidden = 1, .payload_bytes_received = 9, .tiles = 1};
  ToyEngine engine;
  ToyFrames source;
  Posted posted;
  std::unique_ptr<Node> made;
  Node& buffer = *made;
};

using Frames = std::vector<std::int64_t>;

}  // namespace

TEST_CASE("a frame is complete when all nodes have reported and all tiles that they report are here") {
  std::vector<int> order{0, 1, 2, 3};
  do {
    LoneFrameBuffer lone;
    for (std::size_t k = 0; k < order.size(); ++k) {
      CHECK(lone.source.over.empty());
      CHECK_FALSE(lone.engine.finished[0]);
      switch (order[k]) {
        case 0:
          lone.report(0, gp_0, lone.sent);
          break;
        case 1:
          lone.report(0, gp_1, {});
          break;
        case 2:
          lone.give_tile(0, 1);
          break;
        default:
          lone.report(0, renderer_0, lone.drawn);
      }
    }
    REQUIRE(lone.source.over.size() == 1);
    CHECK(lone.engine.finished[0]);
    CHECK(lone.engine.pictures[0].size() == 1);
    CHECK(lone.engine.pictures[0].count(1) == 1);
    CHECK(lone.source.over[0].slices == 3);
    CHECK(lone.source.over[0].total().splats_sent == 5);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST_CASE("sums that do not add up end the run") {
  const auto finish_with = [](const auto& change) {
    LoneFrameBuffer lone;
    change(lone);
    lone.finish(0);
    return lone.source.over.size();
  };
  CHECK(finish_with([](LoneFrameBuffer&) {}) == 1);
  CHECK_THROWS_WITH(finish_with([](LoneFrameBuffer& f) { f.sent.splats_sent = 6; }),
                    Catch::Matchers::Contains("6 splats sent, but 2 drawn, 2 clipped and 1 hidden"));
  CHECK_THROWS_WITH(finish_with([](LoneFrameBuffer& f) { f.drawn.splats_hidden = 0; }),
                    Catch::Matchers::Contains("splats sent"));
  CHECK_THROWS_WITH(finish_with([](LoneFrameBuffer& f) { f.sent.tokens_retired = 0; }),
                    Catch::Matchers::Contains("1 tokens issued, but 0 retired"));
  CHECK_THROWS_WITH(finish_with([](LoneFrameBuffer& f) { f.drawn.payload_bytes_received = 8; }),
                    Catch::Matchers::Contains("9 bytes sent, but 8 received"));
}

TEST_CASE("tiles that are not their sender's, come twice or have another size are errors") {
  LoneFrameBuffer lone(1, {}, {.gps = 2, .renderers = 2});
  const auto refused = Catch::Matchers::Contains("which is not its own or came before");
  CHECK_THROWS_WITH(lone.give_tile(0, 0, {Role::renderer, 1}), refused);
  CHECK_THROWS_WITH(lone.give_tile(0, 0, {Role::gp, 0}), refused);
  CHECK_THROWS_WITH(lone.give_tile(0, 2), refused);
  CHECK_THROWS_WITH(lone.give_tile(0, -1), refused);
  CHECK_THROWS_WITH(lone.give_tile(0, 0, renderer_0, 8), Catch::Matchers::Contains("which has 12"));
  lone.give_tile(0, 0);
  CHECK_THROWS_WITH(lone.give_tile(0, 0), refused);
}

TEST_CASE("reports that come twice, are cut short or are of no frame under way are errors") {
  LoneFrameBuffer lone;
  lone.report(0, gp_0, {});
  CHECK_THROWS_WITH(lone.report(0, gp_0, {}), Catch::Matchers::Contains("GP 0 reported frame 0 twice"));
  CHECK_THROWS_WITH(lone.report(7, gp_0, {}), Catch::Matchers::Contains("which is not being rendered"));
  CHECK_THROWS_WITH(lone.report(0, {Role::host, 1}, {}),
                    Catch::Matchers::Contains("in which it has no part"));
  Bytes body = Message::body_buffer();
  body.resize(body.size() + sizeof(NodeStats) - 1);
  CHECK_THROWS_WITH(
      lone.buffer.receive(Message(make_header(Kind::report, gp_1, frame_buffer_id, 0), std::move(body))),
      Catch::Matchers::Contains("sent a report of"));
}

TEST_CASE("as many frames are under way as may be, and the end is told when all are over") {
  for (const int in_flight : {1, 2, 3}) {
    LoneFrameBuffer lone(4, {.frames_in_flight = in_flight});
    Frames announced = lone.announced(Kind::announcement);
    CHECK(announced.size() == std::size_t(in_flight));
    for (std::int64_t frame = 0; frame < 4; ++frame) {
      CHECK(lone.announced(Kind::shutdown).empty());
      lone.finish(frame);
      const Frames more = lone.announced(Kind::announcement);
      announced.insert(announced.end(), more.begin(), more.end());
      CHECK(announced.size() == std::size_t(std::min<std::int64_t>(4, frame + 1 + in_flight)));
    }
    CHECK(announced == Frames{0, 1, 2, 3});
    CHECK(lone.announced(Kind::shutdown).size() == 1);
    CHECK(lone.source.over.size() == 4);
  }
}

TEST_CASE("frames are handed over in their order, whichever is complete first") {
  LoneFrameBuffer lone(2);
  lone.finish(1);
  CHECK(lone.source.over.empty());
  lone.finish(0);
  REQUIRE(lone.source.over.size() == 2);
  CHECK(lone.source.over[0].frame == 0);
  CHECK(lone.source.over[1].frame == 1);
}

TEST_CASE("a frame that nobody wants is dropped once, and ends without a picture") {
  LoneFrameBuffer lone(1);
  lone.source.to_drop = {0};
  run(lone.buffer);
  CHECK(lone.announced(Kind::drop) == Frames{0});
  run(lone.buffer);
  CHECK(lone.announced(Kind::drop).empty());
  NodeStats unsent = lone.sent;
  unsent.splats_sent = 1000;  // encoded, not sent
  lone.report(0, gp_0, unsent);
  lone.report(0, gp_1, {});
  lone.drawn.tiles = 0;
  lone.report(0, renderer_0, lone.drawn);
  REQUIRE(lone.source.over.size() == 1);
  CHECK(lone.source.over[0].dropped);
  CHECK_FALSE(lone.engine.finished[0]);
}

TEST_CASE("periods of frames do not overlap") {
  for (const int in_flight : {1, 2, 3}) {
    LoneFrameBuffer lone(4, {.frames_in_flight = in_flight});
    for (std::int64_t frame = 0; frame < 4; ++frame) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      lone.finish(frame);
      const FrameStats& stats = lone.source.over.at(std::size_t(frame));
      // Only here no earlier frame was under way when this one was announced.
      if (in_flight == 1 || frame == 0)
        CHECK(stats.period == stats.seconds);
      else
        CHECK(stats.period < stats.seconds);
    }
  }
}

TEST_CASE("the frame buffer says what it waits for") {
  LoneFrameBuffer lone;
  lone.report(0, gp_1, {});
  CHECK(lone.buffer.waiting_for() == "the frame buffer waits for reports on frame 0 from GP 0, Renderer 0");
  lone.report(0, gp_0, lone.sent);
  lone.report(0, renderer_0, lone.drawn);
  CHECK(lone.buffer.waiting_for() == "the frame buffer waits for 1 tile(s) of frame 0");
  lone.give_tile(0, 1);
  CHECK(lone.buffer.waiting_for().empty());
}
