#include "app/measuring.hpp"
#include "app/workshop.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app;
using Catch::Matchers::Contains;

namespace {

/// Ranks on one machine, free to use all of its cores.
std::vector<Binding> unbound(int ranks, const std::string& machine, std::vector<int> cores) {
  return std::vector<Binding>(std::size_t(ranks), {machine, std::move(cores)});
}

std::vector<Binding> joined(std::vector<Binding> a, const std::vector<Binding>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

TEST_CASE("ranks on one machine work as far as it has cores, on several all do") {
  CHECK(ranks_with_cores(unbound(1, "a", {0, 1, 2, 3})) == 1);
  CHECK(ranks_with_cores(unbound(4, "a", {0, 1})) == 2);
  CHECK(ranks_with_cores({{"a", {0}}, {"a", {2}}, {"a", {0}}}) == 2);
  const auto several = joined(unbound(4, "a", {0, 1}), unbound(1, "b", {0, 1, 2}));
  CHECK(ranks_with_cores(several) == 5);
  CHECK(shared_cores(several) == 3);
}

TEST_CASE("a rank takes its share of its machine's cores, and no more than it may use") {
  CHECK(fair_threads(unbound(1, "a", {0, 1, 2, 3}), 0, 1) == 4);
  CHECK(fair_threads(unbound(1, "a", {0, 1, 2, 3}), 0, 16) == 4);  // one process for all nodes
  CHECK(fair_threads(unbound(2, "a", {0, 1, 2, 3}), 1, 2) == 2);
  CHECK(fair_threads(unbound(3, "a", {0, 1, 2, 3}), 0, 3) == 1);
  CHECK(fair_threads(unbound(8, "a", {0, 1, 2, 3}), 0, 8) == 1);
  CHECK(fair_threads(unbound(4, "a", {0, 1, 2, 3}), 0, 2) == 2);  // the others are idle
  CHECK(fair_threads(unbound(4, "a", {0, 1, 2, 3}), 3, 2) == 2);
  CHECK(fair_threads({{"a", {0}}, {"a", {1, 2, 3}}}, 0, 2) == 1);
  CHECK(fair_threads({{"a", {0}}, {"a", {1, 2, 3}}}, 1, 2) == 2);
  const auto several = joined(unbound(2, "a", {0, 1}), unbound(1, "b", {0, 1, 2}));
  CHECK(fair_threads(several, 0, 3) == 1);
  CHECK(fair_threads(several, 2, 3) == 3);
}

TEST_CASE("threads that have to share cores are pointed out, with what to do") {
  CHECK(shared_cores_warning(1, unbound(1, "a", {5}), false).empty());
  CHECK(shared_cores_warning(2, unbound(2, "a", {4, 8}), true).empty());
  CHECK_THAT(shared_cores_warning(3, unbound(1, "a", {0, 1}), false),
             Contains("2 core(s)") && !Contains("mpirun"));
  CHECK_THAT(
      shared_cores_warning(3, {{"a", {0, 1, 2}}, {"a", {3}}, {"b", {0, 1}}}, true),
      Contains("rank 1") && Contains("1 core(s)") && Contains("--bind-to none") && Contains("slot:PE=3"));
}

TEST_CASE("a picture has the same bits with threads, in one process and on ranks", "[threads][mpi]") {
  using namespace ringsplat::app_test;
  const Workshop w("gaussians", "60x56x64", {"--size", "320x240", "--region", "32", "--azimuth", "30"});
  w.render("alone.exr", {"--threads-per-rank", "1"});
  for (const int ranks : {0, 3})
    for (const Words& threads : {Words{}, {"--threads-per-rank", "3"}}) {
      INFO(ranks << " ranks");
      const Ended ended = w.render("shared.exr", threads, ranks);
      CHECK(lines_with(ended.err, "warning").empty() == threads.empty());
      CHECK(same_pictures(w / "shared.exr", w / "alone.exr"));
    }
}

TEST_CASE("ranks measure that bring cores of their own, as far as the machine has room for volumes") {
  using Chosen = std::vector<bool>;
  CHECK(ranks_for_all_cores(unbound(3, "a", {0, 1}), 9) == Chosen{true, false, false});
  const std::vector<Binding> bound{{"a", {0}}, {"a", {1}}, {"b", {0}}, {"a", {1}}, {"a", {2}}};
  CHECK(ranks_for_all_cores(bound, 9) == Chosen{true, true, true, false, true});
  CHECK(ranks_for_all_cores(bound, 2.5) == Chosen{true, true, true, false, false});
  CHECK(ranks_for_all_cores(bound, 0.4) == Chosen{true, false, false, false, false});
}
