// Too little address space, as under ulimit -v, ends with one line and exit code 3, whenever it runs out. The
// address sanitizer needs terabytes of it.
#ifndef __SANITIZE_ADDRESS__
#include "app/workshop.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;

namespace {

Words limited(int megabytes, const Words& arguments) {
  return joined({"--as=" + std::to_string(megabytes) + "000000", RINGSPLAT_PROGRAM}, arguments);
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
  const Workshop w("ball", "40", {"--size", "128", "--threads-per-rank", "2"});
  int failed = 0;
  for (int megabytes = 60; megabytes < 1000; megabytes += megabytes < 360 ? 30 : 80) {
    const Ended ended = run_command(command_of("prlimit", limited(megabytes, w.words("x.png"))));
    check_end(ended, megabytes);
    if (ended.code == 3) CHECK(lines_with(ended.err, "").size() == 1);
    failed += ended.code == 3;
  }
  CHECK(failed > 3);
}

TEST_CASE("a rank without memory says so and ends the job", "[mpi]") {
  const Workshop w("ball", "40", {"--size", "128", "--threads-per-rank", "2"});
  const std::vector<RankGroup> with{{1, w.path(), w.words("x.png")}, {1, w.path(), {}, "prlimit"}};
  for (const bool first : {true, false})
    for (const int megabytes : {100, 330, 480, 600}) {
      std::vector<RankGroup> groups = with;
      groups.back().arguments = limited(megabytes, w.words("x.png"));
      if (first) std::swap(groups.front(), groups.back());
      check_end(run_groups(groups), megabytes);
    }
}
#endif
