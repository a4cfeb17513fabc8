#include "net/loopback.hpp"
#include "protocol/rank.hpp"
#include "support/catch.hpp"
#include "toy_engine.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// Two Renderers draw three of six steps each, and one of them delivers the only tile.
const ToyFrame two_layers{.steps = 6, .gps = 2, .renderers = 2, .tiles = 1, .layer = 3};

struct LoneRenderer {
  explicit LoneRenderer(int index)
      : node(make_renderer({index, {.gps = 2, .renderers = 2}, {}, engine, posted.post()})) {
    node->begin_frame(announcement(0, two_layers));
  }
  void end_without_payloads() {
    node->receive(Message(make_header({Role::gp, 0}, node->id(), 0, FrameEndFields{})));
    run(*node);
  }
  void give_pixels(int from) {
    node->receive(
        Message(make_header(Kind::pixels, {Role::renderer, from}, node->id(), 0), Message::body_buffer()));
    run(*node);
  }

  ToyEngine engine;
  Posted posted;
  std::unique_ptr<Node> node;
};

}  // namespace

TEST_CASE("tokens of layers start at their first slices and end behind their last ones") {
  const Layout layout{.gps = 2, .renderers = 2};
  const ProtocolOptions options{.look_ahead = 3};
  ToyEngine engine;
  Posted posted;
  const auto gp = make_gp({1, layout, options, engine, posted.post()});
  gp->begin_frame(announcement(0, two_layers));
  run(*gp);
  // Of its steps 1, 3 and 5 it begins Renderer 1's tour at 3.
  const auto sent = posted.take(Kind::payload);
  REQUIRE(sent.size() == 1);
  CHECK(token_place(sent[0].header)->step == 3);
  CHECK(token_place(sent[0].header)->renderer == 1);
  const auto gp_0 = make_gp({0, layout, options, engine, posted.post()});
  gp_0->begin_frame(announcement(0, two_layers));
  run(*gp_0);
  const TokenPlace last{.step = 2, .renderer = 0, .sequence = 2};
  gp_0->receive(Message(make_header({Role::gp, 1}, gp_0->id(), 0, TokenFields{last, 0})));
  run(*gp_0);
  gp_0->receive(Message(make_header({Role::renderer, 0}, gp_0->id(), 0, AcceptFields{.place = {0, 0, 0}})));
  run(*gp_0);
  gp_0->receive(Message(make_header({Role::renderer, 0}, gp_0->id(), 0, AcceptFields{.place = last})));
  run(*gp_0);
  const auto ends = posted.take(Kind::frame_end);
  REQUIRE(ends.size() == 1);
  CHECK(ends[0].header.to() == NodeId{Role::renderer, 0});
  CHECK(fields_of<FrameEndFields>(ends[0].header).payloads == 3);
}

TEST_CASE("whoever delivers tiles waits for the layers of all others") {
  LoneRenderer taker(0);
  taker.end_without_payloads();
  CHECK(taker.posted.take(Kind::pixels).size() == 1);  // its own, to itself
  taker.give_pixels(1);
  CHECK(taker.posted.take(Kind::tile).empty());
  CHECK(taker.node->waiting_for() == "Renderer 0 waits for the layers of 1 Renderers of 2 of frame 0");
  CHECK_THROWS_WITH(taker.give_pixels(1), "Renderer 0 got layers of frame 0 twice from Renderer 1");
  taker.give_pixels(0);
  CHECK(taker.engine.painter().gathered.size() == 2);
  CHECK(taker.posted.take(Kind::tile).size() == 1);
  CHECK(taker.posted.take(Kind::report).size() == 1);

  LoneRenderer giver(1);
  giver.end_without_payloads();
  CHECK(giver.posted.take(Kind::pixels).size() == 1);
  CHECK(giver.posted.take(Kind::report).size() == 1);
}

TEST_CASE("of a dropped frame no layers are sent, but who waits for them is told so") {
  LoneRenderer giver(1);
  giver.node->drop_frame(0);
  giver.end_without_payloads();
  const auto pixels = giver.posted.take(Kind::pixels);
  REQUIRE(pixels.size() == 1);
  CHECK(pixels[0].body().empty());
}

TEST_CASE("frames of layers end in any order of messages, with bundles, dropped ones among them") {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    INFO("seed " << seed);
    const Layout layout = seed % 4 == 3 ? mesh_layout(2, 2, 3) : Layout{1 + int(seed % 3), 3};
    ToyFrame frame{.steps = 11, .gps = layout.gps, .renderers = 3, .tiles = 2, .layer = 4};
    frame.ascending = seed % 2 == 0;
    ToyFrames source({frame, frame, frame});
    if (seed % 5 == 0) source.to_drop = {1};
    const auto make = [](int) { return std::make_unique<ToyEngine>(); };
    run_loopback(layout, {.slots = 1 + int(seed % 2), .link_slots = 1, .look_ahead = 1 + int(seed % 3)}, make,
                 source, {.seed = seed, .reorder = true, .max_delay = int(seed % 6)});
    REQUIRE(source.over.size() == 3);
    CHECK(source.over[2].total().tokens_issued == 3);
    CHECK(source.over[2].total().payloads_drawn == 11);
  }
}
