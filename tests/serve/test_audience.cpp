#include "serve/audience.hpp"

#include "support/catch.hpp"

using namespace ringsplat::serve;

TEST_CASE("The first to come drives, and when it goes the one that is here longest") {
  Audience audience;
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

TEST_CASE("A client with two unacknowledged pictures gets no more") {
  Audience audience;
  audience.add(1);
  audience.add(2);
  audience.sent(1, 10);
  audience.sent(1, 11);
  CHECK(audience.unacknowledged() == 2);
  CHECK(audience.takers() == std::vector<ClientId>{2});
  audience.acknowledge(1, 99);
  audience.acknowledge(2, 10);
  CHECK(audience.unacknowledged() == 2);
  audience.acknowledge(1, 10);
  audience.acknowledge(1, 10);
  CHECK(audience.unacknowledged() == 1);
  CHECK(audience.takers() == std::vector<ClientId>{1, 2});
}

TEST_CASE("A client that skipped a picture lacks it once it can take one") {
  Audience audience;
  audience.add(1);
  CHECK(audience.lacks(1, 1));
  audience.sent(1, 1);
  audience.sent(1, 2);
  CHECK(!audience.lacks(1, 3));
  audience.acknowledge(1, 1);
  CHECK(audience.lacks(1, 3));
  CHECK(!audience.lacks(1, 2));
  CHECK(!audience.lacks(7, 3));
}

TEST_CASE("Watchers are told of a scene once, the driver knows") {
  Audience audience;
  audience.add(1);
  audience.add(2);
  CHECK(!audience.must_learn(1, 5));
  CHECK(audience.must_learn(2, 5));
  CHECK(!audience.must_learn(2, 5));
  CHECK(audience.must_learn(2, 6));
}
