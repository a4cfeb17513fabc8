// Too little address space, as under ulimit -v, ends with one line and exit code 3, whenever it runs out. The
// address sanitizer needs terabytes of it.
#ifndef __SANITIZE_ADDRESS__
#include "app/program_runner.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;

namespace {

struct Files {
  TemporaryFolder folder;
  std::string volume = folder / "ball.nrrd";
  Files() { REQUIRE(run_program({"synth", "ball", "-o", volume, "--dims", "40"}).code == 0); }
  std::vector<std::string> render() const {
    return {"render", volume, "-o", folder / "x.png", "--size", "128", "--threads-per-rank", "2"};
  }
};

std::vector<std::string> limited(int megabytes, const std::vector<std::string>& arguments) {
  std::vector<std::string> all{"--as=" + std::to_string(megabytes) + "000000", RINGSPLAT_PROGRAM};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return all;
}

void check_end(const Ended& ended, int megabytes) {
  INFO(megabytes << " MB: " << ended.err);
  // With still less the loader cannot start the program.
  const bool not_started = ended.err.find("error while loading shared libraries") != std::string::npos;
  CHECK((ended.code == 0 || ended.code == 3 || not_started));
  if (ended.code == 3) CHECK(lines_with(ended.err, "error: out of memory; hint: ").size() == 1);
}

}  // namespace

TEST_CASE("a process without memory says so", "[mpi]") {
  const Files files;
  int failed = 0;
  for (int megabytes = 60; megabytes < 1000; megabytes += megabytes < 360 ? 20 : 60) {
    const Ended ended = run_command(command_of("prlimit", limited(megabytes, files.render())));
    check_end(ended, megabytes);
    if (ended.code == 3) CHECK(lines_with(ended.err, "").size() == 1);
    failed += ended.code == 3;
  }
  CHECK(failed > 3);
}

TEST_CASE("a rank without memory says so and ends the job", "[mpi]") {
  const Files files;
  const std::vector<RankGroup> with{{1, files.folder.path(), files.render()},
                                    {1, files.folder.path(), {}, "prlimit"}};
  for (const bool first : {true, false})
    for (const int megabytes : {100, 250, 330, 400, 480, 540, 600, 700}) {
      std::vector<RankGroup> groups = with;
      groups.back().arguments = limited(megabytes, files.render());
      if (first) std::swap(groups.front(), groups.back());
      check_end(run_groups(groups), megabytes);
    }
}
#endif
