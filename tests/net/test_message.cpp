#include <cstddef>

#include "net/message.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat;

namespace {

Bytes wire_of(Message message) {
  const auto block = message.seal();
  return Bytes(block.begin(), block.end());
}

Message with_body(std::size_t bytes) {
  Bytes body = Message::body_buffer();
  body.resize(body.size() + bytes, std::byte{7});
  return Message(make_header({Role::gp, 3}, {Role::renderer, 1}, 5,
                             PayloadFields{.place = {.step = 7, .renderer = 1, .sequence = 9}, .passes = 4}),
                 std::move(body));
}

}  // namespace

TEST_CASE("a message survives the wire") {
  const Message back = Message::from_wire(wire_of(with_body(100)), 0);
  CHECK(back.header.kind == Kind::payload);
  CHECK(back.header.from() == NodeId{Role::gp, 3});
  CHECK(back.header.frame == 5);
  const auto [place, passes] = fields_of<PayloadFields>(back.header);
  CHECK(place.step == 7);
  CHECK(place.renderer == 1);
  CHECK(place.sequence == 9);
  CHECK(passes == 4);
  REQUIRE(back.body().size() == 100);
  CHECK(back.body()[99] == std::byte{7});
  CHECK(Message::from_wire(wire_of(Message(Header{.kind = Kind::token})), 0).body().empty());
}

TEST_CASE("bytes that are no message are refused and the sender is named") {
  const auto refused = [](Bytes bytes) {
    return says(message_of<RunError>([&] { Message::from_wire(std::move(bytes), 42); }), "rank 42");
  };
  CHECK(refused(Bytes(10)));
  Bytes wrong_magic = wire_of(with_body(4));
  wrong_magic[0] = std::byte{0};
  CHECK(refused(wrong_magic));
  Bytes wrong_kind = wire_of(with_body(4));
  wrong_kind[4] = std::byte{200};
  CHECK(refused(wrong_kind));
  for (const std::size_t role : {offsetof(Header, source_role), offsetof(Header, destination_role)})
    for (const int wrong : {4, 255}) {
      Bytes wrong_role = wire_of(with_body(4));
      wrong_role[role] = std::byte(wrong);
      CHECK(refused(wrong_role));
    }
  Bytes truncated = wire_of(with_body(4)), longer = truncated;
  truncated.pop_back();
  CHECK(refused(truncated));
  longer.push_back(std::byte{0});
  CHECK(refused(longer));
}

TEST_CASE("headers that name nodes the run does not have are refused") {
  const Layout layout{.gps = 2, .renderers = 1};
  const Header good = make_header({Role::gp, 0}, {Role::gp, 1}, 0, TokenFields{});
  CHECK_NOTHROW(check(good, layout));
  for (auto change :
       std::vector<void (*)(Header&)>{[](Header& h) { h.destination = 2; }, [](Header& h) { h.source = -1; },
                                      [](Header& h) { h.frame = -1; }}) {
    Header bad = good;
    change(bad);
    CHECK_THROWS_AS(check(bad, layout), RunError);
  }
  for (const TokenPlace place :
       {TokenPlace{.renderer = 1}, TokenPlace{.renderer = -1}, TokenPlace{.step = -1}})
    CHECK_THROWS_AS(check(make_header(good.from(), good.to(), 0, TokenFields{.place = place}), layout),
                    RunError);
}
