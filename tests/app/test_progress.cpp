#include "app/progress.hpp"

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
