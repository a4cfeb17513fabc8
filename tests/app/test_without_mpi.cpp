// The program without MPI, which every build has for this test.
#include "app/workshop.hpp"
#include "ringsplat/config.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;
using Catch::Matchers::Contains;

namespace {

/// Runs the program without MPI; `launcher` is what a launcher would put into its environment.
Ended run_alone(const std::vector<std::string>& arguments, const std::string& launcher = {}) {
  return run_command("env " + launcher + " " + command_of(RINGSPLAT_ALONE, arguments));
}

struct Shell : Workshop {
  Shell() : Workshop("shell", "20", {"--size", "64"}) {}
};

}  // namespace

TEST_CASE("a build without MPI says so among what it was built with") {
  const Ended said = run_alone({"--version"});
  CHECK(said.code == 0);
  CHECK(lines_with(said.out, "without MPI").size() == 1);
  const Ended here = run_program({"--version"});
  CHECK(lines_with(here.out, "ringsplat ").size() == 1);
  CHECK(lines_with(here.out, "without MPI").empty() == bool(RINGSPLAT_WITH_MPI));
}

TEST_CASE("a build without MPI draws the same picture") {
  const Shell w;
  w.render("with.png");
  succeeded(run_alone(w.words("without.png")));
  CHECK(read_text(w / "with.png") == read_text(w / "without.png"));
  succeeded(
      run_alone(w.words("loopback.png", {"--transport", "loopback", "--gps", "3", "--renderers", "2"})));
  CHECK(read_text(w / "loopback.png") == read_text(w / "without.png"));
}

TEST_CASE("a build without MPI refuses to be one of several processes, and to send by MPI") {
  const Shell w;
  for (const std::string launcher : {"OMPI_COMM_WORLD_SIZE=3 PMIX_RANK=0", "PMI_SIZE=2 PMI_RANK=1"}) {
    INFO(launcher);
    const Ended refused = run_alone(w.words("out.png"), launcher);
    check_refused(refused, "this build has no MPI, but a launcher started it");
    CHECK_THAT(refused.err, Contains("-DRINGSPLAT_WITH_MPI=ON"));
    CHECK(lines_with(refused.err, "ringsplat").size() == 1);
  }
  check_refused(run_alone(w.words("out.png", {"--transport", "mpi"})),
                "--transport mpi: this build has no MPI");
  CHECK_FALSE(fs::exists(w / "out.png"));
  succeeded(run_alone(w.words("out.png"), "OMPI_COMM_WORLD_SIZE=1 PMIX_RANK=0"));
}

TEST_CASE("a launcher of several processes without MPI gets no picture", "[mpi]") {
  const Shell w;
  const Ended refused =
      run_command(quoted(RINGSPLAT_MPIEXEC) + " -n 2 " + command_of(RINGSPLAT_ALONE, w.words("out.png")));
  CHECK(refused.code != 0);
  CHECK_THAT(refused.err, Contains("this build has no MPI"));
  CHECK_FALSE(fs::exists(w / "out.png"));
}
