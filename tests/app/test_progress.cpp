#include "program/progress.hpp"

#include <stdexcept>
#include <string>
#include <vector>

#include "support/catch.hpp"

using ringsplat::app::progress_text;

TEST_CASE("a bar shows the part that is done and the time that is left") {
  CHECK(progress_text("loading", 1, 4, 10) == "[#######.......................]  25 %  loading, 30 s left");
  CHECK(progress_text("loading", 4, 4, 10) == "[##############################] 100 %  loading, 0 s left");
  CHECK(progress_text("loading", 9, 4, 10) == "[##############################] 100 %  loading, 0 s left");
}

TEST_CASE("without a known end only the time passes") {
  CHECK(progress_text("rendering", 0, 1, 3) == "rendering, 3 s so far");
  CHECK(progress_text("rendering", 5, 0, 3) == "rendering, 3 s so far");
}

TEST_CASE("a listener is told all progress and results, and may end the work") {
  std::vector<std::string> heard;
  ringsplat::app::Progress progress({[&](const std::string& what, double done, double total) {
                                       if (done == 3) throw std::runtime_error("enough");
                                       heard.push_back(what + " " + std::to_string(int(done)) + "/" +
                                                       std::to_string(int(total)));
                                     },
                                     [&](const std::string& line) { heard.push_back(line); }});
  progress.begin("loading", 4);
  progress.at(2);
  progress.print("a result");
  CHECK_THROWS_WITH(progress.at(3), "enough");
  progress.at(4);
  progress.end();
  CHECK(heard == std::vector<std::string>{"loading 0/4", "loading 2/4", "a result", "loading 4/4"});
}
