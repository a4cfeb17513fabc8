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

namespace {

/// A volume, and a segmentation of half its voxels along each axis.
struct Files {
  TemporaryFolder folder;
  std::string volume = folder / "jack.nrrd", large = folder / "ball.nrrd", picture = folder / "x.exr",
              alone = folder / "alone.exr", whole = folder / "whole.exr";

  Files() {
    REQUIRE(run_program({"synth", "jack", "-o", volume, "--dims", "40x36x44"}).code == 0);
    REQUIRE(run_program({"synth", "ball", "-o", large, "--dims", "20x18x22", "--spacing", "2x2x2"}).code ==
            0);
  }
  void render(const std::string& to, std::vector<std::string> more, int ranks = 0) const {
    more.insert(more.begin(), {"render", volume, "-o", to, "--size", "96x80", "--tf", "grey"});
    const Ended ended = run_program(more, ranks);
    INFO(ended.err);
    CHECK(ended.code == 0);
  }
  bool differs(const std::string& other, const char* bound) const {
    return run_program({"compare", picture, other, "--fail-above", bound}).code == 1;
  }
};

}  // namespace

TEST_CASE("--mask shows what a segmentation covers, with the same bits on ranks", "[mpi]") {
  const Files files;
  const auto& [folder, volume, large, picture, alone, whole] = files;
  const auto render = [&](const std::string& to, std::vector<std::string> more, int ranks = 0) {
    more.insert(more.begin(), {"--azimuth", "30", "--elevation", "20"});
    files.render(to, more, ranks);
  };
  const auto differs = [&](const std::string& other, const char* bound) {
    return files.differs(other, bound);
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

TEST_CASE("--mask-as tints or outlines what a segmentation covers, with the same bits on ranks", "[mpi]") {
  const Files files;
  const std::vector<std::vector<std::string>> views{{"--azimuth", "30", "--elevation", "20"},
                                                    {"--azimuth", "30", "--quality", "draft"},
                                                    {"--slice", "z=20"}};
  for (const auto& view : views)
    for (const char* const as : {"tint", "outline"}) {
      const auto with = [&](std::vector<std::string> more) {
        more.insert(more.end(), view.begin(), view.end());
        return more;
      };
      INFO(view.back() << ' ' << as);
      files.render(files.whole, with({}));
      files.render(files.alone, with({"--mask", files.large, "--mask-as", as}));
      files.render(files.picture, with({"--mask", files.large, "--mask-as", as}), 3);
      CHECK_FALSE(files.differs(files.alone, "0"));
      CHECK(files.differs(files.whole, "0.5"));
    }
  const auto refusal = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"render", files.volume, "-o", files.picture, "--mask-as", "tint"});
    const Ended ended = run_program(more);
    CHECK(ended.code == 2);
    return ended.err;
  };
  CHECK(says(refusal({}), "name the segmentation by --mask FILE"));
  CHECK(says(refusal({"--mask", files.large, "--mode", "mip"}), "only light through sheets, and slices"));
  CHECK(
      says(refusal({"--mask", files.large, "--slice", "plane:1,1,0,0"}), "an oblique slice shows no labels"));
}
