// --trace through the program, on one process and on ranks.
#include <nlohmann/json.hpp>

#include "app/workshop.hpp"
#include "support/catch.hpp"
#include "support/trace_checks.hpp"

using namespace ringsplat::app_test;
using namespace ringsplat::test;
using nlohmann::json;

TEST_CASE("--trace writes a whole timeline, in one process and on five ranks", "[mpi]") {
  for (const int ranks : {0, 5}) {
    INFO(ranks << " ranks");
    const Workshop w("ball", "24x20x22", {"--size", "96x64", "--region", "32"});
    const Ended ended = w.render("x.png",
                                 {"--gps", "3", "--renderers", "2", "--orbit", "3", "--quality", "paper",
                                  "--trace", w / "trace.json", "--stats", w / "stats.json"},
                                 ranks);
    CHECK(ended.err.empty());
    const json trace = json::parse(read_text(w / "trace.json"));
    check_trace(trace, 3, 2, 5);
    CHECK(trace["otherData"]["clocks"].size() == (ranks == 0 ? 1 : 5));
    for (const auto& clock : trace["otherData"]["clocks"]) CHECK(clock["common"] == true);
    CHECK(trace["otherData"]["full"].empty());
    std::size_t tokens = 0, payloads = 0;
    double computing = 0;
    for (const auto& frame : json::parse(read_text(w / "stats.json"))) {
      tokens += frame["total"]["tokens_passed"].get<std::size_t>();
      payloads += frame["total"]["payloads_sent"].get<std::size_t>();
      computing += frame["nodes"][0]["seconds"]["computing"].get<double>();
    }
    CHECK(flows(trace, "token") == tokens);
    CHECK(flows(trace, "payload") == payloads);
    CHECK(busy_seconds(trace, "GP 0", "slice") == Approx(computing).epsilon(1e-4).margin(2e-6));
    CHECK(files_in(w.path()) == 6);  // the volume, three pictures, trace and statistics
  }
}
