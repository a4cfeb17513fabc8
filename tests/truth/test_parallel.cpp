#include "truth/parallel.hpp"

#include <atomic>
#include <chrono>
#include <numeric>
#include <thread>
#include <vector>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

TEST_CASE("every place of a range is worked on once, and the caller sees what was written", "[threads]") {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{7}, std::size_t{1000}})
    for (const std::size_t piece : {std::size_t{1}, std::size_t{3}, std::size_t{2000}}) {
      std::vector<int> input(count), seen(count, 0);
      for (int round = 1; round <= 20; ++round) {
        std::iota(input.begin(), input.end(), round);
        truth::parallel_for(count, piece, [&](std::size_t first, std::size_t end) {
          for (std::size_t k = first; k < end; ++k) seen[k] += input[k];
        });
      }
      for (std::size_t k = 0; k < count; ++k) REQUIRE(seen[k] == 20 * int(k) + 210);
    }
}

TEST_CASE("what a piece throws comes to the caller, and the rest is left", "[threads]") {
  constexpr int pieces = 20'000;
  std::atomic<int> begun = 0;
  const auto work = [&] {
    truth::parallel_for(pieces, 1, [&](std::size_t first, std::size_t) {
      ++begun;
      if (first == 10) throw RunError("piece 10");
      // Delays the other threads until this one has thrown.
      if (first > 10) std::this_thread::sleep_for(std::chrono::microseconds(50));
    });
  };
  CHECK_THROWS_WITH(work(), Catch::Matchers::Contains("piece 10"));
  CHECK(begun < pieces);
}

TEST_CASE("the calling thread polls between its pieces, and what that throws ends the work", "[threads]") {
  constexpr int pieces = 20'000;
  std::atomic<int> begun = 0;
  const auto caller = std::this_thread::get_id();
  int polls = 0;
  const auto work = [&] {
    truth::parallel_for(
        pieces, 1,
        [&](std::size_t, std::size_t) {
          ++begun;
          std::this_thread::sleep_for(std::chrono::microseconds(50));
        },
        [&](double done) {
          REQUIRE(std::this_thread::get_id() == caller);
          CHECK((0 <= done && done < 1));
          if (++polls == 3) throw RunError("enough");
        });
  };
  CHECK_THROWS_WITH(work(), Catch::Matchers::Contains("enough"));
  CHECK(polls == 3);
  CHECK(begun < pieces);
}
