#include "base/thread_team.hpp"

#include <atomic>
#include <limits>
#include <thread>
#include <vector>

#include "base/process.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

TEST_CASE("a team runs every lane once and hands on what one throws", "[threads]") {
  for (const int threads : {1, 2, 3, 8}) {
    ThreadTeam team(threads);
    CHECK(team.size() == threads);
    for (int lanes = 0; lanes <= threads + 3; ++lanes) {
      std::vector<std::atomic<int>> ran(std::size_t(threads) + 3);
      for (int k = 0; k < 200; ++k) team.run(lanes, [&](int lane) { ++ran[std::size_t(lane)]; });
      for (int lane = 0; lane < threads + 3; ++lane)
        CHECK(ran[std::size_t(lane)] == (lane < lanes ? 200 : 0));
    }
    CHECK_THROWS_AS(team.run(threads,
                             [&](int lane) {
                               if (lane == threads - 1) throw RunError("lane");
                             }),
                    RunError);
    std::atomic<int> ran = 0;
    team.run(threads, [&](int) { ++ran; });
    CHECK(ran == threads);
  }
}

TEST_CASE("lanes see what was written before them, and the caller what they wrote", "[threads]") {
  ThreadTeam team(4);
  std::vector<int> numbers(4, 0);
  for (int k = 0; k < 500; ++k) {
    team.run(4, [&](int lane) { numbers[std::size_t(lane)] = numbers[std::size_t(lane)] + lane; });
    for (int& number : numbers) ++number;
  }
  for (int lane = 0; lane < 4; ++lane) CHECK(numbers[std::size_t(lane)] == 500 * (lane + 1));
}

// Wrong on purpose: the thread sanitizer must report it. Run by name only.
TEST_CASE("two lanes write the same number at once", "[.race]") {
  ThreadTeam team(2);
  std::atomic<int> here = 0;
  int number = 0;
  team.run(2, [&](int lane) {
    here.fetch_add(1, std::memory_order_relaxed);
    while (here.load(std::memory_order_relaxed) < 2) std::this_thread::yield();
    number += lane;
  });
  CHECK(number >= 0);
}

TEST_CASE("teams share their threads one after another", "[threads]") {
  ThreadTeam wide(8), narrow(2);
  std::atomic<int> ran = 0;
  for (int k = 0; k < 100; ++k) {
    wide.run(8, [&](int) { ++ran; });
    narrow.run(2, [&](int) { ++ran; });
  }
  CHECK(ran == 1000);
}

#if defined(__SSE2__)
TEST_CASE("denormals are flushed in all lanes that share", "[threads]") {
  ThreadTeam team(5);
  std::atomic<int> denormals = 0;
  for (int k = 0; k < 200; ++k)
    team.run(5, [&](int) {
      volatile float small = std::numeric_limits<float>::min();
      small = small * 0.5F;
      if (small != 0) ++denormals;
    });
  CHECK(denormals == 0);
}
#endif

TEST_CASE("a number of threads that no rank can have is refused with a hint") {
  for (const int threads : {-1, 0, 1025, 2'000'000'000}) {
    CHECK_THROWS_AS(ThreadTeam(threads), InputError);
    CHECK_THROWS_WITH(ThreadTeam(threads), Catch::Matchers::Contains("--threads-per-rank takes 1 to 1024"));
  }
}

TEST_CASE("a process may run on at least one core") { CHECK_FALSE(allowed_cores().empty()); }
