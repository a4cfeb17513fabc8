#include "base/byte_stream.hpp"
#include "net/mesh.hpp"
#include "support/catch.hpp"
#include "toy_engine.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// A GP alone, by default in a ring of two GPs.
struct LoneGp {
  explicit LoneGp(const ProtocolOptions& options = {}, Layout l = {.gps = 2, .renderers = 1}, int index = 0)
      : layout(l), made(make_gp({index, layout, options, engine, posted.post()})) {}

  void begin(std::int64_t number, const ToyFrame& frame) {
    gp.begin_frame(announcement(number, frame));
    run(gp);
  }
  void give_token(std::int64_t frame, const TokenFields& token) {
    gp.receive(Message(make_header({Role::gp, 1}, gp.id(), frame, token)));
    run(gp);
  }
  void accept(std::int64_t frame, const TokenPlace& place, std::uint32_t free_slots = 3) {
    Bytes news = Message::body_buffer();
    append(news, 7);
    gp.receive(Message(make_header({Role::renderer, place.renderer}, gp.id(), frame,
                                   AcceptFields{.place = place, .free_slots = free_slots}),
                       std::move(news)));
    run(gp);
  }
  std::vector<TokenFields> tokens() {
    std::vector<TokenFields> all;
    for (const Message& m : posted.take(Kind::token)) all.push_back(fields_of<TokenFields>(m.header));
    return all;
  }
  std::vector<TokenPlace> payloads() {
    std::vector<TokenPlace> all;
    for (const Message& m : posted.take(Kind::payload)) all.push_back(*token_place(m.header));
    return all;
  }
  bool reported() { return !posted.take(Kind::report).empty(); }

  Layout layout;
  ToyEngine engine;
  Posted posted;
  std::unique_ptr<Node> made;
  Node& gp = *made;
};

}  // namespace

TEST_CASE("a token stays until its payload is accepted, then goes to the owner of the next slice") {
  LoneGp lone;
  lone.begin(0, {.steps = 4});
  const auto sent = lone.payloads();
  REQUIRE(sent.size() == 1);
  CHECK(sent[0].step == 0);
  CHECK(sent[0].sequence == 0);
  CHECK(lone.tokens().empty());
  lone.accept(0, sent[0]);
  const auto messages = lone.posted.take(Kind::token);
  REQUIRE(messages.size() == 1);
  CHECK(messages[0].header.to() == NodeId{Role::gp, 1});
  const auto token = fields_of<TokenFields>(messages[0].header);
  CHECK(token.place.step == 1);
  CHECK(token.place.sequence == 1);
  CHECK(token.credits == 0);
  CHECK(lone.engine.encoders.at(0)->news_taken == sizeof(int));
}

TEST_CASE("tokens start at the owner of the front slice only, one for each Renderer that has a tile") {
  const Layout layout{.gps = 2, .renderers = 3};
  const ToyFrame frame{.steps = 5, .gps = 2, .renderers = 3, .tiles = 2, .ascending = false};
  LoneGp front({}, layout, 0), other({}, layout, 1);
  front.begin(0, frame);
  other.begin(0, frame);
  CHECK(other.payloads().empty());
  const auto sent = front.payloads();
  REQUIRE(sent.size() == 2);
  // In the traversal's order, which keeps a mesh free of contention.
  CHECK(sent[0].renderer == 1);
  CHECK(sent[1].renderer == 0);
}

TEST_CASE("a slice without a payload costs its token alone, which keeps its number") {
  LoneGp lone;
  lone.begin(0, {.steps = 4, .empty_payloads = 0b0001});
  CHECK(lone.payloads().empty());
  const auto tokens = lone.tokens();
  REQUIRE(tokens.size() == 1);
  CHECK(tokens[0].place.step == 1);
  CHECK(tokens[0].place.sequence == 0);
}

TEST_CASE("tokens pass over slices that show nothing") {
  LoneGp lone;
  lone.begin(0, {.steps = 6, .hidden_steps = 0b011110});  // 0 and 5 are left
  const auto sent = lone.payloads();
  REQUIRE(sent.size() == 1);
  lone.accept(0, sent[0]);
  const auto tokens = lone.tokens();
  REQUIRE(tokens.size() == 1);
  CHECK(tokens[0].place.step == 5);
  CHECK(lone.reported());
}

TEST_CASE("who has the last slice tells the Renderer how many payloads there were") {
  LoneGp lone({}, {.gps = 1, .renderers = 1});
  lone.begin(0, {.steps = 3, .gps = 1, .empty_payloads = 0b010});
  std::uint32_t payloads = 0;
  for (auto sent = lone.payloads(); !sent.empty(); sent = lone.payloads()) {
    REQUIRE(sent.size() == 1);
    CHECK(sent[0].sequence == payloads++);
    CHECK(lone.posted.take(Kind::frame_end).empty());
    lone.accept(0, sent[0]);
    // A GP's tokens to itself come back through the host.
    for (const auto& token : lone.tokens()) lone.give_token(0, token);
    for (const auto& token : lone.tokens()) lone.give_token(0, token);
  }
  const auto end = lone.posted.take(Kind::frame_end);
  REQUIRE(end.size() == 1);
  CHECK(payloads == 2);
  CHECK(fields_of<FrameEndFields>(end[0].header).payloads == payloads);
  CHECK(lone.reported());
}

TEST_CASE("with credits a token moves with its payload, as far as there are slots, and accepts bring more") {
  LoneGp lone({.slots = 4, .send_ahead = 2});
  lone.begin(0, {.steps = 6});
  auto tokens = lone.tokens();
  REQUIRE(lone.payloads().size() == 1);
  REQUIRE(tokens.size() == 1);
  CHECK(tokens[0].credits == 1);
  CHECK(tokens[0].place.sequence == 1);
  lone.accept(0, {.step = 0, .renderer = 0, .sequence = 0});
  CHECK(lone.tokens().empty());  // the token has already moved on

  // A token without credits waits for its accept, which brings a credit for each free slot, at most two.
  for (const auto& [free_slots, credits] : {std::pair{3U, 2U}, {1U, 1U}, {0U, 0U}}) {
    LoneGp waiting({.slots = 4, .send_ahead = 2});
    waiting.begin(0, {.steps = 6, .hidden_steps = 0b000001});
    waiting.give_token(0, {.place = {.step = 2, .sequence = 1}, .credits = 0});
    REQUIRE(waiting.payloads().size() == 1);
    CHECK(waiting.tokens().empty());
    waiting.accept(0, {.step = 2, .renderer = 0, .sequence = 1}, free_slots);
    const auto after = waiting.tokens();
    REQUIRE(after.size() == 1);
    CHECK(after[0].credits == credits);
    CHECK(after[0].place.sequence == 2);
  }
}

TEST_CASE("a frame is over for a GP only when all accepts have come, and a mesh's tokens never run ahead") {
  LoneGp lone({.slots = 4, .send_ahead = 4});
  lone.begin(0, {.steps = 2});
  REQUIRE(lone.tokens().size() == 1);
  CHECK_FALSE(lone.reported());
  lone.accept(0, {.step = 0, .renderer = 0, .sequence = 0});
  CHECK(lone.reported());

  LoneGp meshed({.slots = 4, .send_ahead = 4}, mesh_layout(2, 1, 1));
  meshed.begin(0, {.steps = 4});
  CHECK(meshed.payloads().size() == 1);
  CHECK(meshed.tokens().empty());
}

TEST_CASE("a GP prepares at most as many slices as it may, of the earliest frame first") {
  for (const int look_ahead : {1, 2, 5}) {
    LoneGp lone({.look_ahead = look_ahead}, {.gps = 2, .renderers = 1}, 1);
    lone.begin(0, {.steps = 8});
    lone.begin(1, {.steps = 8});
    const auto prepared = std::size_t(std::min(look_ahead, 4));
    // A token for a prepared slice is used at once, without work in between.
    std::size_t used = 0;
    for (int step = 1; step < 8; step += 2) {
      lone.gp.receive(
          Message(make_header({Role::gp, 0}, lone.gp.id(), 0,
                              TokenFields{.place = {.step = step, .sequence = std::uint32_t(step)}})));
      used += lone.payloads().size();
    }
    CHECK(used == prepared);
  }
}

TEST_CASE("stale and foreign messages are errors that name the sender") {
  LoneGp lone({}, {.gps = 2, .renderers = 1}, 1);
  lone.begin(0, {.steps = 2});
  lone.give_token(0, {.place = {.step = 1, .sequence = 1}});
  const auto sent = lone.payloads();
  REQUIRE(sent.size() == 1);
  CHECK_THROWS_WITH(lone.give_token(0, {.place = {.step = 0}}), Catch::Matchers::Contains("not its own"));
  CHECK_THROWS_WITH(lone.give_token(0, {.place = {.step = 1000}}), Catch::Matchers::Contains("not its own"));
  for (const TokenPlace& other : {TokenPlace{.step = 1, .sequence = 2}, TokenPlace{.step = 1, .sequence = 0},
                                  TokenPlace{.step = 0, .sequence = 1}, TokenPlace{1, 1, 1}})
    CHECK_THROWS_WITH(lone.accept(0, other), Catch::Matchers::Contains("which it did not send"));
  CHECK_THROWS_WITH(lone.gp.receive(Message(make_header(Kind::report, {Role::renderer, 0}, lone.gp.id(), 0))),
                    Catch::Matchers::Contains("cannot use a report (from Renderer 0)"));
  CHECK_FALSE(lone.reported());
  lone.accept(0, sent[0]);
  CHECK(lone.reported());
  CHECK_THROWS_WITH(lone.give_token(0, {.place = {.step = 1}}),
                    Catch::Matchers::Contains("after that frame was over"));
}

TEST_CASE("of a dropped frame nothing more is encoded, but its tokens go round") {
  LoneGp lone;
  lone.begin(0, {.steps = 6});
  REQUIRE(lone.payloads().size() == 1);
  lone.gp.drop_frame(0);
  lone.accept(0, {.step = 0, .renderer = 0, .sequence = 0});
  REQUIRE(lone.tokens().size() == 1);
  for (const int step : {2, 4}) {
    lone.give_token(0, {.place = {.step = step, .sequence = 1}});
    const auto tokens = lone.tokens();
    REQUIRE(tokens.size() == 1);
    CHECK(tokens[0].place.sequence == 1);
  }
  CHECK(lone.payloads().empty());
  CHECK(lone.reported());

  // What was prepared before is sent: payloads of later frames may rely on it.
  LoneGp prepared({.look_ahead = 4}, {.gps = 2, .renderers = 1}, 1);
  prepared.begin(0, {.steps = 4});
  prepared.gp.drop_frame(0);
  prepared.give_token(0, {.place = {.step = 1}});
  CHECK(prepared.payloads().size() == 1);
  prepared.accept(0, {.step = 1, .renderer = 0, .sequence = 0});
  CHECK(prepared.tokens().size() == 1);
}

TEST_CASE("a volume beside the picture has no tokens and no slices to encode") {
  LoneGp lone;
  lone.begin(0, {.steps = 6, .tiles = 0});
  CHECK(lone.tokens().empty());
  const auto reports = lone.posted.take(Kind::report);
  REQUIRE(reports.size() == 1);
  NodeStats stats;
  std::size_t at = 0;
  REQUIRE(take(reports[0].body(), at, stats));
  CHECK(stats.voxels_outside == 3);
  CHECK(stats.slices == 0);
}

TEST_CASE("a GP does what comes before the first slice in pieces") {
  LoneGp lone;
  lone.gp.begin_frame(announcement(0, {.steps = 2, .prepare_pieces = 3}));
  for (int piece = 0; piece < 3; ++piece) {
    CHECK(lone.gp.advance());
    CHECK(lone.payloads().empty());
  }
  CHECK(lone.gp.advance());
  CHECK(lone.payloads().size() == 1);
}

TEST_CASE("a GP says what it waits for") {
  LoneGp lone;
  CHECK(lone.gp.waiting_for().empty());
  lone.begin(0, {.steps = 4});
  CHECK(lone.gp.waiting_for() == "GP 0 waits for Renderer 0 to accept step 0 of frame 0");
  lone.accept(0, {.step = 0, .renderer = 0, .sequence = 0});
  CHECK(lone.gp.waiting_for() == "GP 0 waits for 1 token(s) of step 2 of frame 0 from GP 1");
}
