#include "protocol/bundle_engine.hpp"
#include "protocol/joined_step.hpp"

#include <cstring>

#include "support/catch.hpp"
#include "toy_engine.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// Seven slices from slice 2 on, in bundles 2 3 | 4 5 6 7 | 8.
constexpr ToyFrame part_of_a_volume{.steps = 7, .gps = 2, .renderers = 1, .bundle = 4, .first_slice = 2};

EncodedStep encoded(Encoder& encoder, int step) {
  encoder.begin(step);
  while (!encoder.work()) {
  }
  return encoder.finish();
}

}  // namespace

TEST_CASE("bundles are those of the volume, in either direction") {
  const auto plan = [](const ToyFrame& frame) {
    return make_bundle_engine(std::make_unique<ToyEngine>(), frame.bundle)->plan(announcement(0, frame));
  };
  ToyFrame frame = part_of_a_volume;
  CHECK(plan(frame).slices_of_steps == std::vector{2, 4, 1});
  CHECK(plan(frame).owners == std::vector{0, 1, 0});
  CHECK(plan(frame).slices() == 7);
  frame.ascending = false;
  CHECK(plan(frame).slices_of_steps == std::vector{1, 4, 2});
  CHECK(plan(frame).owners == std::vector{0, 1, 0});
}

TEST_CASE(
    "a token stays until the payload of the bundle's slices is accepted, then goes to the next bundle's GP") {
  const auto engine = make_bundle_engine(std::make_unique<ToyEngine>(), 4);
  Posted posted;
  const auto made = make_gp({0, {.gps = 2, .renderers = 1, .bundle = 4}, {}, *engine, posted.post()});
  Node& gp = *made;
  gp.begin_frame(announcement(0, part_of_a_volume));
  run(gp);
  const auto payloads = posted.take(Kind::payload);
  REQUIRE(payloads.size() == 1);
  CHECK(posted.messages.empty());
  const TokenPlace place = fields_of<PayloadFields>(payloads.front().header).place;
  CHECK(fields_of<PayloadFields>(payloads.front().header).passes == 2);
  gp.receive(Message(make_header({Role::renderer, 0}, gp.id(), 0, AcceptFields{.place = place})));
  run(gp);
  const auto tokens = posted.take(Kind::token);
  REQUIRE(tokens.size() == 1);
  CHECK(tokens.front().header.destination == 1);
  CHECK(fields_of<TokenFields>(tokens.front().header).place.step == 1);
  CHECK(posted.messages.empty());
}

TEST_CASE("a bundle's payload has its slices' payloads and says as much as they do") {
  const Announcement frame = announcement(0, part_of_a_volume);
  const auto engine = make_bundle_engine(std::make_unique<ToyEngine>(), 4);
  const EncodedPart part = encoded(*engine->encoder(1, frame), 1).parts.front();
  CHECK(part.items == 4);
  CHECK(part.passes == 4);
  const auto body = std::span<const std::byte>(part.payload).subspan(sizeof(Header));
  std::size_t at = 0, joined = 0;
  for (int slice = 1; slice <= 4; ++slice) {
    JoinedPart head;
    REQUIRE(take_part(body, at, head));
    CHECK(head.number == slice + 1);
    CHECK(head.bytes == sizeof(ToyItem));
    joined = joined_with(joined, head.bytes);
    at += head.bytes;
  }
  CHECK(joined == body.size());
  CHECK(at == body.size());
}

TEST_CASE("a damaged payload of a bundle is refused with the Renderer's and the bundle's number") {
  const auto engine = make_bundle_engine(std::make_unique<ToyEngine>(), 4);
  const Announcement frame = announcement(0, part_of_a_volume);
  const Bytes whole = encoded(*engine->encoder(1, frame), 1).parts.front().payload;
  const auto painter = engine->painter(0, frame);
  const auto body = [](const Bytes& wire) { return std::span(wire).subspan(sizeof(Header)); };
  const auto draw = [&](int bundle, const Bytes& wire) {
    painter->begin({bundle, 4, body(wire)});
    while (!painter->work()) {
    }
  };
  const auto refused = Catch::Matchers::Contains("Renderer 0 got a payload of bundle");
  for (std::size_t size = sizeof(Header); size < whole.size(); ++size) {
    // At the end of a slice's part what is left is whole, but has fewer slices.
    const std::size_t part = sizeof(JoinedPart) + sizeof(ToyItem);
    if (size > sizeof(Header) && (size - sizeof(Header)) % part == 0) continue;
    CAPTURE(size);
    CHECK_THROWS_WITH(draw(1, Bytes(whole.begin(), whole.begin() + std::ptrdiff_t(size))), refused);
  }
  for (const int bundle : {-1, 0, 2, 3, 100}) CHECK_THROWS_WITH(draw(bundle, whole), refused);
  const auto with_step = [&](std::size_t part, std::int32_t step) {
    Bytes wire = whole;
    std::memcpy(wire.data() + sizeof(Header) + part * (sizeof(JoinedPart) + sizeof(ToyItem)), &step,
                sizeof step);
    return wire;
  };
  for (const int step : {-1, 2, 6, 1 << 30}) CHECK_THROWS_WITH(draw(1, with_step(1, step)), refused);
  CHECK_NOTHROW(draw(1, whole));
}
