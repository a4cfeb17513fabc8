#include "serve/audience.hpp"

#include "support/catch.hpp"

using namespace ringsplat::serve;

namespace {

/// An audience, and the pictures and texts that reached each client.
struct Heard {
  std::map<ClientId, std::vector<int>> pictures;
  std::map<ClientId, int> texts;
  Audience audience{[this](ClientId client, bool binary, const auto&) {
    if (binary)
      pictures[client].push_back(int(audience.last()->head.number));
    else
      ++texts[client];
  }};

  void show(std::uint64_t scene = 1) {
    audience.show({{std::make_shared<const std::string>(picture_message({}, "file"))}, {}, {}, scene});
  }
};

}  // namespace

TEST_CASE("The first to come drives, and when it goes the one that is here longest") {
  Audience audience{{}};
  for (const ClientId client : {4, 5, 6}) audience.add(client);
  CHECK(audience.drives(4));
  audience.drive(6);
  CHECK(audience.drives(6));
  audience.remove(6);
  CHECK(audience.drives(4));
  audience.drive(99);
  CHECK(audience.drives(4));
  audience.remove(4);
  audience.remove(5);
  for (const ClientId client : {4, 5, 6, 99}) CHECK(!audience.drives(client));
}

TEST_CASE("Two pictures that belong together come together, and are acknowledged as one") {
  std::vector<std::string> heard;
  Audience audience{[&](ClientId, bool binary, const auto& bytes) {
    if (binary) heard.push_back(bytes->substr(8, 4) + bytes->substr(44));
  }};
  audience.add(1);
  const auto message = std::make_shared<const std::string>(picture_message({}, "file"));
  audience.show({{message, message}, {}, {}, 1});
  const std::string number("\1\0\0\0", 4);
  CHECK(heard ==
        std::vector{number + std::string("\0\0\1\0file", 8), number + std::string("\1\0\0\0file", 8)});
  CHECK(audience.unacknowledged() == 1);
  audience.acknowledge(1, 1);
  CHECK(audience.unacknowledged() == 0);
}

TEST_CASE("A client with two unacknowledged pictures gets no more") {
  Heard heard;
  Audience& audience = heard.audience;
  audience.add(1);
  heard.show();
  heard.show();
  audience.add(2);
  heard.show();
  CHECK(audience.unacknowledged() == 2);
  CHECK(heard.pictures[1] == std::vector{1, 2});
  CHECK(heard.pictures[2] == std::vector{3});
  audience.acknowledge(1, 99);
  audience.acknowledge(2, 1);
  CHECK(audience.unacknowledged() == 2);
  audience.acknowledge(1, 1);
  audience.acknowledge(1, 1);
  CHECK(heard.pictures[1] == std::vector{1, 2, 3});
  CHECK(heard.pictures[2] == std::vector{3});
}

TEST_CASE("A client that skipped pictures gets the last of them once it can take one") {
  Heard heard;
  heard.audience.add(1);
  heard.audience.catch_up(1);
  CHECK(heard.pictures.empty());
  for (int k = 0; k < 4; ++k) heard.show();
  heard.audience.acknowledge(1, 1);
  heard.audience.acknowledge(1, 2);
  CHECK(heard.pictures[1] == std::vector{1, 2, 4});
  heard.audience.catch_up(7);
  CHECK(heard.pictures.size() == 1);
  heard.audience.add(2);
  heard.audience.catch_up(2);
  CHECK(heard.pictures[2] == std::vector{4});
}

TEST_CASE("Watchers are told of a scene once, the driver knows") {
  Heard heard;
  heard.audience.add(1);
  heard.audience.add(2);
  heard.show(5);
  heard.show(5);
  CHECK(heard.texts == std::map<ClientId, int>{{2, 1}});
  heard.audience.acknowledge(2, 1);
  heard.show(6);
  CHECK(heard.texts == std::map<ClientId, int>{{2, 2}});
  heard.audience.say("text");
  heard.audience.say_who_drives();
  CHECK(heard.texts == std::map<ClientId, int>{{1, 2}, {2, 4}});
}
