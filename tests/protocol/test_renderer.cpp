#include "base/byte_stream.hpp"
#include "support/catch.hpp"
#include "toy_engine.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

struct LoneRenderer {
  explicit LoneRenderer(const ProtocolOptions& options = {}, int index = 0, int renderers = 1)
      : made(make_renderer({index, {.gps = 2, .renderers = renderers}, options, engine, posted.post()})) {}

  void begin(std::int64_t number, const ToyFrame& frame) {
    renderer.begin_frame(announcement(number, frame));
  }
  void give_payload(std::int64_t frame, int step, std::uint32_t sequence) {
    Bytes body = Message::body_buffer();
    append(body, ToyItem{frame, step});
    const PayloadFields fields{
        .place = {.step = step, .renderer = renderer.id().index, .sequence = sequence}};
    renderer.receive(
        Message(make_header({Role::gp, step % 2}, renderer.id(), frame, fields), std::move(body)));
  }
  void end(std::int64_t frame, std::uint32_t payloads) {
    renderer.receive(
        Message(make_header({Role::gp, 0}, renderer.id(), frame, FrameEndFields{.payloads = payloads})));
  }
  /// Payloads accepted since the last call: sequence and the number of free slots in the accept.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> accepts() {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> all;
    for (const Message& m : posted.take(Kind::accept)) {
      const auto fields = fields_of<AcceptFields>(m.header);
      all.emplace_back(fields.place.sequence, fields.free_slots);
    }
    return all;
  }

  ToyEngine engine;
  Posted posted;
  std::unique_ptr<Node> made;
  Node& renderer = *made;
};

using Accepts = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

}  // namespace

TEST_CASE("payloads are drawn by their numbers, in whatever order they come") {
  std::vector<int> order{0, 1, 2, 3};
  do {
    LoneRenderer lone({.slots = 4});
    lone.begin(0, {.steps = 8});
    for (const int k : order) {
      lone.give_payload(0, 2 * k, std::uint32_t(k));
      run(lone.renderer);
    }
    CHECK(lone.engine.painter().steps == std::vector<int>{0, 2, 4, 6});
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST_CASE("a Renderer does what belongs to no payload while it waits for one, and not in their way") {
  LoneRenderer lone({.slots = 4});
  lone.begin(0, {.steps = 4, .spare_pieces = 4});
  CHECK(lone.renderer.advance());
  lone.give_payload(0, 0, 0);
  lone.give_payload(0, 2, 2);
  CHECK(lone.renderer.advance());
  CHECK(lone.renderer.advance());  // payload 1 is missing
  lone.give_payload(0, 1, 1);
  CHECK(lone.renderer.advance());
  CHECK(lone.renderer.advance());
  CHECK(lone.engine.painter().steps == std::vector<int>{-2, 0, -2, 1, 2});
  CHECK(lone.renderer.advance());
  CHECK(lone.renderer.advance());
  CHECK_FALSE(lone.renderer.advance());  // nothing is left to do
  lone.renderer.drop_frame(0);
}

TEST_CASE("a payload is accepted when it has a slot, by the order of numbers") {
  LoneRenderer lone({.slots = 2});
  lone.begin(0, {.steps = 8});
  lone.give_payload(0, 1, 1);
  CHECK(lone.accepts() == Accepts{{1, 0}});
  lone.give_payload(0, 2, 2);
  CHECK(lone.accepts().empty());  // both slots belong to 0 and 1
  run(lone.renderer);
  CHECK(lone.accepts().empty());  // without 0 nothing can be drawn
  lone.give_payload(0, 0, 0);
  CHECK(lone.accepts() == Accepts{{0, 1}});
  CHECK(lone.renderer.advance());
  CHECK(lone.accepts() == Accepts{{2, 0}});
  run(lone.renderer);
  CHECK(lone.engine.painter().steps == std::vector<int>{0, 1, 2});
}

TEST_CASE("accepts go to the sender and bring it news of this frame") {
  LoneRenderer lone;
  lone.begin(0, {.steps = 8});
  lone.begin(1, {.steps = 8});
  run(lone.renderer);
  lone.give_payload(0, 1, 0);
  lone.give_payload(1, 1, 0);
  const auto accepts = lone.posted.take(Kind::accept);
  REQUIRE(accepts.size() == 2);
  CHECK(accepts[0].header.to() == NodeId{Role::gp, 1});
  CHECK(accepts[0].header.from() == NodeId{Role::renderer, 0});
  int told = -1;
  REQUIRE(accepts[0].body().size() == sizeof told);
  std::memcpy(&told, accepts[0].body().data(), sizeof told);
  CHECK(told == 1);
  // The next frame's painter has no news yet.
  CHECK(accepts[1].body().empty());
  CHECK(accepts[1].header.frame == 1);
}

TEST_CASE("payloads beyond the slots, twice, or of frames delivered are errors that name the sender") {
  LoneRenderer lone({.slots = 2});
  lone.begin(0, {.steps = 8});
  CHECK_THROWS_WITH(lone.give_payload(0, 3, 3), Catch::Matchers::Contains("GP 1"));
  LoneRenderer twice;
  twice.begin(0, {.steps = 8});
  twice.give_payload(0, 0, 0);
  CHECK_THROWS_WITH(twice.give_payload(0, 0, 0),
                    Catch::Matchers::Contains("twice, the second time from GP 0"));
  run(twice.renderer);
  CHECK_THROWS_WITH(twice.give_payload(0, 0, 0), Catch::Matchers::Contains("twice"));
  twice.end(0, 1);
  CHECK_THROWS_WITH(twice.end(0, 1), Catch::Matchers::Contains("told twice"));
  run(twice.renderer);
  CHECK_THROWS_WITH(twice.give_payload(0, 2, 1), Catch::Matchers::Contains("after that frame was delivered"));
}

TEST_CASE("tiles are delivered when the last payload is drawn, and not before its number is known") {
  LoneRenderer lone({}, 1, 2);
  lone.begin(0, {.steps = 3, .renderers = 2, .tiles = 5});
  lone.give_payload(0, 0, 0);
  lone.give_payload(0, 2, 1);
  run(lone.renderer);
  CHECK(lone.posted.take(Kind::tile).empty());
  lone.end(0, 2);
  run(lone.renderer);
  const auto tiles = lone.posted.take(Kind::tile);
  REQUIRE(tiles.size() == 2);
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    CHECK(fields_of<TileFields>(tiles[k].header).tile == int(1 + 2 * k));
    std::vector<int> steps(3);
    REQUIRE(tiles[k].body().size() == 3 * sizeof(int));
    std::memcpy(steps.data(), tiles[k].body().data(), 3 * sizeof(int));
    CHECK(steps == std::vector<int>{0, 2, -1});
  }
  NodeStats stats;
  std::size_t at = 0;
  const auto reports = lone.posted.take(Kind::report);
  REQUIRE(reports.size() == 1);
  REQUIRE(take(reports[0].body(), at, stats));
  CHECK(stats.tiles == 2);
  CHECK(stats.payloads_drawn == 2);
  CHECK(stats.splats_drawn == 2);
  CHECK(stats.payload_bytes_received == 2 * sizeof(ToyItem));
}

TEST_CASE("a Renderer without a tile waits for nothing") {
  LoneRenderer lone({}, 1, 2);
  lone.begin(0, {.steps = 3, .renderers = 2, .tiles = 1});
  run(lone.renderer);
  CHECK(lone.posted.take(Kind::tile).empty());
  CHECK(lone.posted.take(Kind::report).size() == 1);
}

TEST_CASE("frames are drawn one after another, the earliest first") {
  LoneRenderer lone;
  lone.begin(0, {.steps = 4});
  lone.begin(1, {.steps = 4});
  lone.give_payload(1, 0, 0);
  lone.end(1, 1);
  run(lone.renderer);
  CHECK(lone.posted.take(Kind::report).empty());
  lone.give_payload(0, 3, 0);
  lone.end(0, 1);
  run(lone.renderer);
  const auto reports = lone.posted.take(Kind::report);
  REQUIRE(reports.size() == 2);
  CHECK(reports[0].header.frame == 0);
  CHECK(reports[1].header.frame == 1);
}

TEST_CASE("payloads of a dropped frame are accepted and not drawn") {
  LoneRenderer lone({.slots = 1});
  lone.begin(0, {.steps = 4});
  run(lone.renderer);
  lone.renderer.drop_frame(0);
  for (std::uint32_t k = 0; k < 3; ++k) {
    lone.give_payload(0, int(k), k);
    run(lone.renderer);
    CHECK(lone.accepts().size() == 1);
  }
  lone.end(0, 3);
  run(lone.renderer);
  CHECK(lone.engine.painter().steps.empty());
  CHECK(lone.posted.take(Kind::tile).empty());
  CHECK(lone.posted.take(Kind::report).size() == 1);
}

TEST_CASE("a Renderer says what it waits for") {
  LoneRenderer lone;
  CHECK(lone.renderer.waiting_for().empty());
  lone.begin(0, {.steps = 4});
  CHECK(lone.renderer.waiting_for() == "Renderer 0 waits for payload 0 of frame 0 or for its end");
  lone.end(0, 2);
  CHECK(lone.renderer.waiting_for() == "Renderer 0 waits for payload 0 of 2 of frame 0");
  lone.give_payload(0, 0, 0);
  CHECK(lone.renderer.waiting_for() == "Renderer 0 has payload 0 of frame 0 to draw");
}
