// The program without MPI, which every build has for this test.
#include "app/program_runner.hpp"
#include "ringsplat/config.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;
using Catch::Matchers::Contains;

namespace {

/// Runs the program without MPI; `launcher` is what a launcher would put into its environment.
Ended run_alone(const std::vector<std::string>& arguments, const std::string& launcher = {}) {
  return run_command("env " + launcher + " " + command_of(RINGSPLAT_ALONE, arguments));
}

/// The arguments that make a picture of an analytic volume.
std::vector<std::string> picture(const TemporaryFolder& folder, const std::string& name) {
  if (!fs::exists(folder / "shell.nrrd"))
    REQUIRE(run_program({"synth", "shell", "-o", folder / "shell.nrrd", "--dims", "20"}).code == 0);
  return {"render", folder / "shell.nrrd", "--size", "64", "-o", folder / name};
}

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
  const TemporaryFolder folder;
  REQUIRE(run_program(picture(folder, "with.png")).code == 0);
  REQUIRE(run_alone(picture(folder, "without.png")).code == 0);
  CHECK(read_text(folder / "with.png") == read_text(folder / "without.png"));
  auto many = picture(folder, "loopback.png");
  for (const char* word : {"--transport", "loopback", "--gps", "3", "--renderers", "2"})
    many.emplace_back(word);
  REQUIRE(run_alone(many).code == 0);
  CHECK(read_text(folder / "loopback.png") == read_text(folder / "without.png"));
}

TEST_CASE("a build without MPI refuses to be one of several processes") {
  const TemporaryFolder folder;
  const auto arguments = picture(folder, "out.png");
  for (const std::string launcher : {"OMPI_COMM_WORLD_SIZE=3 PMIX_RANK=0", "PMI_SIZE=2 PMI_RANK=1"}) {
    const Ended refused = run_alone(arguments, launcher);
    INFO(launcher);
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Contains("this build has no MPI, but a launcher started it") &&
                                Contains("-DRINGSPLAT_WITH_MPI=ON"));
    CHECK(lines_with(refused.err, "ringsplat").size() == 1);
    CHECK_FALSE(fs::exists(folder / "out.png"));
  }
  CHECK(run_alone(arguments, "OMPI_COMM_WORLD_SIZE=1 PMIX_RANK=0").code == 0);
}

TEST_CASE("a build without MPI refuses to send by it") {
  const TemporaryFolder folder;
  auto arguments = picture(folder, "out.png");
  arguments.insert(arguments.end(), {"--transport", "mpi"});
  const Ended refused = run_alone(arguments);
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err,
             Contains("--transport mpi: this build has no MPI") && Contains("-DRINGSPLAT_WITH_MPI=ON"));
  CHECK_FALSE(fs::exists(folder / "out.png"));
}

TEST_CASE("a launcher of several processes without MPI gets no picture", "[mpi]") {
  const TemporaryFolder folder;
  const auto arguments = picture(folder, "out.png");
  const Ended refused =
      run_command(quoted(RINGSPLAT_MPIEXEC) + " -n 2 " + command_of(RINGSPLAT_ALONE, arguments));
  CHECK(refused.code != 0);
  CHECK_THAT(refused.err, Contains("this build has no MPI"));
  CHECK_FALSE(fs::exists(folder / "out.png"));
}
