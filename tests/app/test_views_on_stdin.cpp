// A path on stdin, in one process and on ranks.
#include "app/workshop.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;

namespace {

struct Files : Workshop {
  Files() : Workshop("gaussians", "40x36x44", {"--size", "96x64", "--region", "32"}) {}
  Ended draw(int ranks, const std::string& lines) const {
    return run_program(words("x.png", {"--path", "-"}), ranks, lines);
  }
};

}  // namespace

TEST_CASE("a path on stdin is that of a file with the same lines", "[mpi]") {
  const Files files;
  const std::string lines = "azimuth elevation\n10 5\n\n100 5\n";
  write_text(files / "path.csv", lines);
  files.render("y.png", {"--path", files / "path.csv"});
  for (const int ranks : {0, 2}) {
    INFO(ranks << " ranks");
    succeeded(files.draw(ranks, lines));
    CHECK(same_pictures(files / "x-0000.png", files / "y-0000.png"));
    CHECK(same_pictures(files / "x-0001.png", files / "y-0001.png"));
  }
}

TEST_CASE("a line on stdin that gives no view is named, and nothing is drawn", "[mpi]") {
  const Files files;
  for (const int ranks : {0, 2}) {
    INFO(ranks << " ranks");
    check_refused(files.draw(ranks, "10 5\nleft\x1b[31m\xff\n"), "--path -:2: 'left\\x1b[31m\\xff' is not");
    // Longer than any pipe or buffer. Launchers may end a job that reads less quickly than they do.
    check_refused(files.draw(ranks, "10 5\n" + std::string(ranks == 0 ? 3'000'000 : 30'000, 'y') + "\n"),
                  "--path -:2: '" + std::string(60, 'y') + "...'");
    check_refused(files.draw(ranks, "10 5 0 0\n"), "zoom");
    check_refused(files.draw(ranks, ""), "there is no view in it");
    CHECK_FALSE(fs::exists(files / "x-0000.png"));
  }
}
