#include "app/threads.hpp"

#include "app/program_runner.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app;
using Catch::Matchers::Contains;

TEST_CASE("threads that have to share cores are pointed out, with what to do") {
  CHECK(shared_cores_warning(1, {1}, false).empty());
  CHECK(shared_cores_warning(4, {4, 8}, true).empty());
  CHECK_THAT(shared_cores_warning(3, {2}, false), Contains("2 core(s)") && !Contains("mpirun"));
  CHECK_THAT(shared_cores_warning(3, {4, 1, 2}, true), Contains("rank 1") && Contains("1 core(s)") &&
                                                           Contains("--bind-to none") &&
                                                           Contains("slot:PE=3"));
}

TEST_CASE("a picture has the same bits with threads, in one process and on ranks",
          "[threads][mpi][openimageio]") {
  using namespace ringsplat::app_test;
  const TemporaryFolder folder;
  const std::string volume = folder / "gaussians.nrrd", alone = folder / "alone.exr",
                    shared = folder / "shared.exr";
  REQUIRE(run_program({"synth", "gaussians", "-o", volume, "--dims", "60x56x64"}).code == 0);
  for (const std::string plane : {"screen", "slices"}) {
    const std::vector<std::string> view{"render", volume,      "--size", "320x240",       "--region",
                                        "32",     "--azimuth", "30",     "--image-plane", plane};
    const auto render = [&](const std::string& file, std::vector<std::string> more, int ranks) {
      more.insert(more.begin(), view.begin(), view.end());
      more.insert(more.end(), {"-o", file});
      return run_program(more, ranks);
    };
    REQUIRE(render(alone, {}, 0).code == 0);
    for (const int ranks : {0, 2, 3}) {
      const Ended ended = render(shared, {"--threads-per-rank", "3"}, ranks);
      INFO(plane << " on " << ranks << " ranks: " << ended.err);
      REQUIRE(ended.code == 0);
      CHECK(run_program({"compare", shared, alone, "--fail-above", "0"}).code == 0);
    }
  }
}
