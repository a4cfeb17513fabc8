#include "program/launch.hpp"

#include <algorithm>
#include <new>

#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app;

namespace {

RunOptions options(std::optional<int> gps, std::optional<int> renderers,
                   std::optional<Placement> placement = {}) {
  RunOptions o;
  o.gps = gps;
  o.renderers = renderers;
  o.placement = placement;
  return o;
}

}  // namespace

TEST_CASE("without options as many ranks as there are cores are GP and Renderer, and no other has work") {
  for (int ranks = 1; ranks <= 64; ++ranks)
    for (const int cores : {0, 1, 2, 16}) {
      const Layout layout = choose_layout({}, true, ranks, cores);
      CHECK(layout.placement == Placement::colocated);
      CHECK(layout.ranks() == ranks);
      CHECK(layout.gps == (cores == 0 ? ranks : std::min(ranks, cores)));
      CHECK(layout.renderers == layout.gps);
    }
  CHECK(choose_layout({}, false, 1, 8) == Layout{1, 1, Placement::dedicated, Topology::ring});
}

TEST_CASE("roles that were asked for leave no rank idle") {
  CHECK(choose_layout(options({}, {}, Placement::colocated), true, 5, 2) ==
        Layout{5, 5, Placement::colocated, Topology::ring});
  CHECK(choose_layout(options({}, {}, Placement::dedicated), true, 6, 2) ==
        Layout{4, 2, Placement::dedicated, Topology::ring});
  CHECK(choose_layout(options(4, {}), true, 6, 2) == Layout{4, 2, Placement::dedicated, Topology::ring});
}

TEST_CASE("one count follows from the other and the job's") {
  CHECK(choose_layout(options(4, {}), true, 6).renderers == 2);
  CHECK(choose_layout(options({}, 1), true, 6).gps == 5);
  CHECK(choose_layout(options(2, {}, Placement::colocated), true, 6) ==
        Layout{2, 6, Placement::colocated, Topology::ring});
  CHECK(choose_layout(options(12, 4), false, 1) == Layout{12, 4, Placement::dedicated, Topology::ring});
}

TEST_CASE("ranks beyond the cores may be idle when no count was given") {
  const auto may_be_idle = [](const RunOptions& o) {
    const auto layouts = layouts_to_choose_from(o, true, 5, 2);
    return std::any_of(layouts.begin(), layouts.end(), [](const Layout& l) { return l.idle > 0; });
  };
  CHECK(may_be_idle({}));
  CHECK(may_be_idle(options({}, {}, Placement::colocated)));
  CHECK_FALSE(may_be_idle(options({}, 2)));
  CHECK_FALSE(may_be_idle(options(2, {})));
}

TEST_CASE("counts that do not fit are refused with the number that does") {
  const auto refused = [](const RunOptions& o, int ranks, const std::string& part) {
    CHECK_THROWS_WITH(choose_layout(o, true, ranks), Catch::Matchers::Contains(part));
  };
  refused(options(4, 2), 5, "mpirun -n 6");
  refused(options(1, 1), 1, "--roles colocated");
  refused(options(3, {}), 3, "mpirun -n 4");
  refused(options(3, 2, Placement::colocated), 4, "need 3");
  refused(options(0, {}), 4, "--gps is 0");
  refused(options(2'000'000'000, 2'000'000'000), 4, "far more");
  CHECK_THROWS_AS(choose_layout(options(4000, 4000), false, 1), InputError);
  CHECK_THROWS_AS(choose_layout({}, false, 2), InputError);
}

TEST_CASE("bundles are part of any layout, and chosen for described machines only") {
  RunOptions o = options(4, 2);
  CHECK(choose_layout(o, true, 6).bundle == 1);
  o.bundle = 8;
  CHECK(choose_layout(o, true, 6).bundle == 8);
  CHECK(choose_layout(o, false, 1).bundle == 8);
  o.gps.reset();
  for (const Layout& layout : layouts_to_choose_from(o, true, 6)) CHECK(layout.bundle == 8);
  o.bundle = 0;
  CHECK_THROWS_WITH(choose_layout(o, true, 6), Catch::Matchers::Contains("--bundle is 0"));
  o.bundle.reset();
  o.choose_roles = o.choose_bundle = true;
  for (const bool over_mpi : {true, false})
    CHECK_THROWS_WITH(choose_layout(o, over_mpi, over_mpi ? 6 : 1),
                      Catch::Matchers::Contains("--bundle auto"));
}

TEST_CASE("every way to fail has its exit code") {
  CHECK(guarded([] { return ExitCode::comparison_failed; }).code == ExitCode::comparison_failed);
  const auto input = guarded([]() -> ExitCode { throw InputError("line one\nline two", "do this"); });
  CHECK(input.code == ExitCode::bad_input);
  CHECK(input.error == "line one line two; hint: do this");
  CHECK(guarded([]() -> ExitCode { throw RunError("a rank died"); }).code == ExitCode::run_failed);
  const auto memory = guarded([]() -> ExitCode { throw std::bad_alloc(); });
  CHECK(memory.code == ExitCode::run_failed);
  CHECK_THAT(memory.error, Catch::Matchers::Contains("out of memory"));
  CHECK(guarded([]() -> ExitCode { throw std::runtime_error("oops"); }).code == ExitCode::run_failed);
}
