// Views on stdin, in one process and on ranks.
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/workshop.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;
using nlohmann::json;

namespace {

struct Files : Workshop {
  Files() : Workshop("gaussians", "40x36x44", {"--size", "96x64", "--region", "32"}) {}
  /// True when a picture equals that of a separate run.
  bool same_as_alone(const std::string& name, const Words& more) const {
    render("alone.png", more);
    return same_pictures(*this / name, *this / "alone.png");
  }
};

}  // namespace

TEST_CASE("lines on stdin that give no view are skipped, the others are rendered, and the run ends with 2",
          "[mpi]") {
  for (const int ranks : {0, 2}) {
    INFO(ranks << " ranks");
    const Files files;
    // A zoom of 0 is a view that cannot be rendered; the long line is longer than any pipe or buffer.
    // Launchers may end a job that reads less quickly than they do, as MPICH's does.
    const std::string lines = "10 5\nleft\x1b[31m\xff\n20 5 0 0\n" +
                              std::string(ranks == 0 ? 3'000'000 : 30'000, 'y') + "\n100 5\n";
    const Ended ended =
        run_program(files.words("x.png", {"--path", "-", "--stats", files / "stats.json"}), ranks, lines);
    INFO(ended.err);
    CHECK(ended.code == 2);
    const auto warnings = lines_with(ended.err, "warning: skipped");
    REQUIRE(warnings.size() == 3);
    CHECK_THAT(warnings[0], Catch::Matchers::Contains("line 2: 'left\\x1b[31m\\xff' is not"));
    CHECK_THAT(warnings[1], Catch::Matchers::Contains("line 3: "));
    CHECK_THAT(warnings[2], Catch::Matchers::Contains("line 4: '" + std::string(60, 'y') + "...'"));
    CHECK(ended.err.find('\x1b') == std::string::npos);
    const auto errors = lines_with(ended.err, "error: --path -");
    REQUIRE(errors.size() == 1);
    CHECK_THAT(errors[0], Catch::Matchers::Contains("3 of the lines give no view and were skipped"));
    CHECK(files.same_as_alone("x-0000.png", {"--azimuth", "10", "--elevation", "5", "--fit", "sphere"}));
    CHECK(files.same_as_alone("x-0001.png", {"--azimuth", "100", "--elevation", "5", "--fit", "sphere"}));
    CHECK(json::parse(read_text(files / "stats.json")).size() == 2);
  }
}

TEST_CASE("a run that only waits for views says so, and not that it renders") {
  const Files files;
  const std::string command =
      "timeout -k 2 60 " + command_of(RINGSPLAT_PROGRAM, files.words("x.png", {"--path", "-"}));
  const std::string said = files / "err";
  std::FILE* program = popen((command + " 2>" + quoted(said) + " >/dev/null").c_str(), "w");
  REQUIRE(program != nullptr);
  std::string text;
  for (int tries = 0; tries < 3000 && text.find('\n') == std::string::npos; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    text = read_text(said);
  }
  CHECK_THAT(text, Catch::Matchers::StartsWith("ringsplat: waiting for views on stdin\n"));
  std::fputs("10 5\n", program);
  CHECK(pclose(program) == 0);
  CHECK(files.same_as_alone("x-0000.png", {"--azimuth", "10", "--elevation", "5", "--fit", "sphere"}));
}
