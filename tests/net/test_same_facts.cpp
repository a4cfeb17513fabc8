#include "net/agree.hpp"

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/thread_collectives.hpp"

using namespace ringsplat;
using ringsplat::test::run_as_processes;
using ringsplat::test::ThreadCollectives;

namespace {

/// The message that every process throws (the same one) when process p has facts[p].
std::string refusal(const std::vector<Facts>& facts) {
  const auto thrown = run_as_processes(int(facts.size()), [&](ThreadCollectives& collectives) {
    require_same(collectives, facts[std::size_t(collectives.process())], "is odd", "be even");
  });
  for (const auto& one : thrown) CHECK(one == thrown.front());
  return thrown.front();
}

}  // namespace

TEST_CASE("processes with the same facts agree") {
  CHECK(refusal({{}}).empty());
  CHECK(refusal({{}, {}, {}}).empty());
  CHECK(refusal({{{"size", "3"}, {"type", "uint8"}}, {{"size", "3"}, {"type", "uint8"}}}).empty());
}

TEST_CASE("the first process that differs is named with the first field that does") {
  CHECK(refusal({{{"size", "3"}, {"type", "uint8"}},
                 {{"size", "3"}, {"type", "uint8"}},
                 {{"size", "3"}, {"type", "int8"}}}) ==
        "rank 2 is odd: type int8, rank 0 has uint8; hint: be even");
  CHECK(refusal({{{"size", "3"}, {"type", "uint8"}}, {{"size", "4"}, {"type", "int8"}}}) ==
        "rank 1 is odd: size 4, rank 0 has 3; hint: be even");
  CHECK(refusal({{{"size", "3"}}, {{"size", "4"}}, {{"size", "3"}}, {{"size", "5"}}}) ==
        "rank 1 is odd: size 4, rank 0 has 3 (1 more rank differs); hint: be even");
  CHECK(refusal({{{"size", "3"}}, {{"size", "4"}}, {{"size", "5"}}, {{"size", "5"}}}) ==
        "rank 1 is odd: size 4, rank 0 has 3 (2 more ranks differ); hint: be even");
}

TEST_CASE("a field that one process lacks is a difference") {
  CHECK(refusal({{{"size", "3"}}, {}}) == "rank 1 is odd: size (none), rank 0 has 3; hint: be even");
  CHECK(refusal({{}, {{"size", "3"}}}) == "rank 1 is odd: size 3, rank 0 has (none); hint: be even");
  CHECK(refusal({{{"size", "3"}}, {{"size", "3"}, {"name", ""}}}) ==
        "rank 1 is odd: name , rank 0 has (none); hint: be even");
}

TEST_CASE("facts cost eight bytes a process while they agree and stay with two processes when they do not") {
  const Facts facts(1000, {"a field with a name", "and a value"});
  std::vector<std::size_t> sent(4, 0);
  const auto compare = [&](ThreadCollectives& collectives, const Facts& mine) {
    static_cast<void>(input_error_of([&] { require_same(collectives, mine, "is odd", "be even"); }));
    sent[std::size_t(collectives.process())] = collectives.sent();
  };
  run_as_processes(4, [&](ThreadCollectives& collectives) { compare(collectives, facts); });
  CHECK(sent == std::vector<std::size_t>(4, 8));
  run_as_processes(4, [&](ThreadCollectives& collectives) {
    Facts mine = facts;
    if (collectives.process() >= 2) mine.push_back({"one", "more"});
    compare(collectives, mine);
  });
  CHECK(sent[0] > 8);
  CHECK(sent[1] == 8);
  CHECK(sent[2] > 8);
  CHECK(sent[3] == 8);
}
