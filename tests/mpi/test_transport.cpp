#include <mpi.h>

#include <algorithm>
#include <string>
#include <vector>

#include "mpi/connections.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

int world_rank() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

Message numbered(std::uint32_t sequence, std::size_t bytes) {
  Bytes body = Message::body_buffer();
  for (std::size_t k = 0; k < bytes; ++k) body.push_back(static_cast<std::byte>((k * 31 + sequence) & 255));
  return Message(
      make_header({Role::gp, 0}, {Role::renderer, 0}, 0, PayloadFields{.place = {.sequence = sequence}}),
      std::move(body));
}

std::uint32_t number_of(const Message& m) { return token_place(m.header)->sequence; }

bool intact(const Message& m) {
  for (std::size_t k = 0; k < m.body().size(); ++k)
    if (m.body()[k] != static_cast<std::byte>((k * 31 + number_of(m)) & 255)) return false;
  return true;
}

}  // namespace

TEST_CASE("messages of all sizes arrive whole, also those sent in parts") {
  const std::size_t part = GENERATE(std::size_t{64}, std::size_t{1000}, largest_mpi_part);
  const auto transport = make_mpi_transport(MPI_COMM_WORLD, part);
  const int to = (transport->rank() + 1) % transport->ranks();
  // Sizes around a part's: bodies that end with a part, or a byte before or after.
  const std::vector<std::size_t> sizes{0, 1, 15, 16, 17, 79, 80, 81, 951, 952, 953, 5000, 100000};
  for (std::uint32_t k = 0; k < sizes.size(); ++k) transport->send(to, numbered(k, sizes[k]));
  std::vector<int> seen(sizes.size());
  std::size_t received = 0;
  while (received < sizes.size()) {
    auto message = transport->receive();
    if (!message) {
      transport->wait_next();
      continue;
    }
    REQUIRE(number_of(*message) < sizes.size());
    REQUIRE(message->body().size() == sizes[number_of(*message)]);
    REQUIRE(intact(*message));
    ++seen[number_of(*message)];
    ++received;
  }
  CHECK(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
  while (!transport->sends_done()) transport->wait_next();
  MPI_Barrier(MPI_COMM_WORLD);
}

TEST_CASE("collectives carry blocks of different sizes, in parts too") {
  const std::size_t part = GENERATE(std::size_t{2}, std::size_t{7}, largest_mpi_part);
  const auto collectives = make_mpi_collectives(MPI_COMM_WORLD, part);
  const int me = collectives->process(), ranks = collectives->processes();
  std::vector<Block> out;
  for (int p = 0; p < ranks; ++p)
    out.emplace_back(std::size_t(10 * me + p), static_cast<std::byte>(16 * me + p));
  const auto in = collectives->all_to_all(out);
  const auto all = collectives->all_gather(Block(std::size_t(me), static_cast<std::byte>(me)));
  for (int p = 0; p < ranks; ++p) {
    REQUIRE(in[std::size_t(p)] == Block(std::size_t(10 * p + me), static_cast<std::byte>(16 * p + me)));
    REQUIRE(all[std::size_t(p)] == Block(std::size_t(p), static_cast<std::byte>(p)));
  }
}

TEST_CASE("values are added up over all processes, each by itself") {
  const auto collectives = make_mpi_collectives(MPI_COMM_WORLD);
  const auto me = std::uint64_t(collectives->process()), ranks = std::uint64_t(collectives->processes());
  std::vector<std::uint64_t> values{1, me, std::uint64_t{1} << 40};
  collectives->sum(values);
  CHECK(values == std::vector<std::uint64_t>{ranks, ranks * (ranks - 1) / 2, ranks << 40});
}

TEST_CASE("an error on one rank is thrown on all and names that rank") {
  const auto collectives = make_mpi_collectives(MPI_COMM_WORLD);
  CHECK_NOTHROW(agree(*collectives, ""));
  const int culprit = collectives->processes() - 1;
  try {
    agree(*collectives, world_rank() == culprit ? "no such file" : "");
    FAIL("no error was thrown");
  } catch (const InputError& e) {
    CHECK(std::string(e.what()).find("no such file") != std::string::npos);
    CHECK(std::string(e.what()).find(culprit == 0 ? "file" : "rank " + std::to_string(culprit)) !=
          std::string::npos);
  }
}
