// --mask: what people type, and the program itself, in one process and on ranks.
#include "app/program_runner.hpp"
#include "options/option_values.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat;
using namespace ringsplat::app_test;

TEST_CASE("a mask is a file, or a file and labels of it") {
  const auto mask = [](const char* text) { return app::parse_mask(text, "--mask"); };
  CHECK(mask("seg.nrrd").path == "seg.nrrd");
  CHECK(mask("seg.nrrd").labels.empty());
  CHECK(mask("a=b.nii=1,3-5").path == "a=b.nii");
  CHECK(mask("a=b.nii=1,3-5").labels == LabelRanges{{1, 1}, {3, 5}});
  const auto refusal = [&](const char* text) { return message_of([&] { mask(text); }); };
  CHECK(says(refusal("=1"), "--mask '=1' names no file"));
  for (const char* text : {"s=", "s=1,,2", "s=a", "s=1-2-3", "s=-1", "s=1.5"})
    CHECK(says(refusal(text), "has something else than labels behind ="));
  CHECK(says(refusal("s=5-3"), "has a range of labels that ends before it begins"));
}

TEST_CASE("--mask shows what a segmentation covers, with the same bits on ranks", "[mpi]") {
  const TemporaryFolder folder;
  const std::string volume = folder / "jack.nrrd", large = folder / "ball.nrrd", picture = folder / "x.exr",
                    alone = folder / "alone.exr", whole = folder / "whole.exr";
  REQUIRE(run_program({"synth", "jack", "-o", volume, "--dims", "40x36x44"}).code == 0);
  REQUIRE(run_program({"synth", "ball", "-o", large, "--dims", "20x18x22", "--spacing", "2x2x2"}).code == 0);
  const auto render = [&](const std::string& to, std::vector<std::string> more, int ranks = 0) {
    more.insert(more.begin(), {"render", volume, "-o", to, "--size", "96x80", "--tf", "grey", "--azimuth",
                               "30", "--elevation", "20"});
    const Ended ended = run_program(more, ranks);
    INFO(ended.err);
    CHECK(ended.code == 0);
  };
  const auto differs = [&](const std::string& other, const char* bound) {
    return run_program({"compare", picture, other, "--fail-above", bound}).code == 1;
  };
  render(whole, {});
  // Where there is nothing else than 0, nothing is taken away.
  render(picture, {"--mask", volume});
  CHECK_FALSE(differs(whole, "0"));
  render(alone, {"--mask", large});
  render(picture, {"--mask", large}, 3);
  CHECK_FALSE(differs(alone, "0"));
  CHECK(differs(whole, "1"));
  render(picture, {"--mask", large, "--engine", "splats"});
  CHECK(differs(whole, "1"));
  render(picture, {"--mask", large + "=1-255"});
  CHECK_FALSE(differs(alone, "0"));

  const Ended none = run_program({"info", volume, "--mask", folder / "none.nrrd"});
  CHECK(none.code == 2);
  CHECK(says(none.err, "none.nrrd"));
}
