// --trace through the program, on one process and on ranks.
#include <nlohmann/json.hpp>

#include "app/succeeded.hpp"
#include "support/catch.hpp"
#include "support/trace_checks.hpp"

using namespace ringsplat::app_test;
using namespace ringsplat::test;
using nlohmann::json;

namespace {

struct Files {
  TemporaryFolder folder;
  std::string volume = folder / "ball.nrrd", picture = folder / "x.png", trace = folder / "trace.json",
              stats = folder / "stats.json";
  Files() { REQUIRE(run_program({"synth", "ball", "-o", volume, "--dims", "24x20x22"}).code == 0); }
  std::vector<std::string> render(std::vector<std::string> more) const {
    more.insert(more.begin(), {"render", volume, "-o", picture, "--size", "96x64", "--region", "32"});
    return more;
  }
};

}  // namespace

TEST_CASE("--trace writes a whole timeline, in one process and on five ranks", "[mpi]") {
  for (const int ranks : {0, 5}) {
    INFO(ranks << " ranks");
    const Files files;
    const Ended ended =
        succeeded(run_program(files.render({"--gps", "3", "--renderers", "2", "--orbit", "3", "--quality",
                                            "paper", "--trace", files.trace, "--stats", files.stats}),
                              ranks));
    CHECK(ended.err.empty());
    const json trace = json::parse(read_text(files.trace));
    check_trace(trace, 3, 2, 5);
    CHECK(trace["otherData"]["clocks"].size() == (ranks == 0 ? 1 : 5));
    for (const auto& clock : trace["otherData"]["clocks"]) CHECK(clock["common"] == true);
    CHECK(trace["otherData"]["full"].empty());
    std::size_t tokens = 0, payloads = 0;
    double computing = 0;
    for (const auto& frame : json::parse(read_text(files.stats))) {
      tokens += frame["total"]["tokens_passed"].get<std::size_t>();
      payloads += frame["total"]["payloads_sent"].get<std::size_t>();
      computing += frame["nodes"][0]["seconds"]["computing"].get<double>();
    }
    CHECK(flows(trace, "token") == tokens);
    CHECK(flows(trace, "payload") == payloads);
    CHECK(busy_seconds(trace, "GP 0", "slice") == Approx(computing).epsilon(1e-4).margin(2e-6));
    CHECK(files_in(files.folder.path()) == 6);  // the volume, three pictures, trace and statistics
  }
}

TEST_CASE("a trace that cannot be written is refused before anything is rendered", "[mpi]") {
  for (const int ranks : {0, 2}) {
    const Files files;
    for (const std::string& bad :
         {files.folder / "missing/trace.json", files.folder.path().string(), files.picture}) {
      INFO(bad);
      const Ended ended = run_program(files.render({"--trace", bad}), ranks);
      CHECK(ended.code == 2);
      CHECK_THAT(ended.err, Catch::Matchers::Contains("--trace"));
      CHECK_THAT(ended.err, Catch::Matchers::Contains("hint"));
      CHECK_FALSE(fs::exists(files.picture));
      CHECK(files_in(files.folder.path()) == 1);
    }
  }
}
