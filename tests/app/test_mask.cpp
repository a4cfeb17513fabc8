// --mask: what people type, and the program itself, in one process and on ranks.
#include "app/workshop.hpp"
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
struct Files : Workshop {
  std::string large = *this / "ball.nrrd", picture = *this / "x.exr", alone = *this / "alone.exr",
              whole = *this / "whole.exr";

  Files() : Workshop("jack", "40x36x44", {"--size", "96x80", "--tf", "grey"}) {
    succeeded(run_program({"synth", "ball", "-o", large, "--dims", "20x18x22", "--spacing", "2x2x2"}));
  }
  bool differs(const std::string& other, const char* bound) const {
    return run_program({"compare", picture, other, "--fail-above", bound}).code == 1;
  }
};

}  // namespace

TEST_CASE("--mask shows what a segmentation covers, with the same bits on ranks", "[mpi]") {
  const Files files;
  files.render("whole.exr");
  // Where there is nothing else than 0, nothing is taken away.
  files.render("x.exr", {"--mask", files.volume()});
  CHECK(same_pictures(files.picture, files.whole));
  files.render("alone.exr", {"--mask", files.large});
  files.render("x.exr", {"--mask", files.large}, 3);
  CHECK(same_pictures(files.picture, files.alone));
  CHECK(files.differs(files.whole, "1"));
  files.render("x.exr", {"--mask", files.large, "--engine", "splats"});
  CHECK(files.differs(files.whole, "1"));
  files.render("x.exr", {"--mask", files.large + "=1-255"});
  CHECK(same_pictures(files.picture, files.alone));

  check_refused(run_program({"info", files.volume(), "--mask", files / "none.nrrd"}), "none.nrrd");
}

TEST_CASE("--mask-as tints or outlines what a segmentation covers, with the same bits on ranks", "[mpi]") {
  const Files files;
  const std::vector<std::pair<std::string, Words>> cases{
      {"tint", {"--azimuth", "30", "--elevation", "20"}},
      {"outline", {"--azimuth", "30", "--quality", "draft"}},
      {"tint", {"--slice", "z=20"}},
      {"outline", {"--slice", "z=20"}}};
  for (const auto& [as, view] : cases) {
    INFO(view.back() << ' ' << as);
    const Words masked = joined(view, {"--mask", files.large, "--mask-as", as});
    files.render("whole.exr", view);
    files.render("alone.exr", masked);
    files.render("x.exr", masked, 3);
    CHECK(same_pictures(files.picture, files.alone));
    CHECK(files.differs(files.whole, "0.5"));
  }
  files.render("x.exr", {"--mask", files.large, "--mask-as", "outline", "--error", "certified"});
  const auto refusal = [&](const Words& more) {
    return run_program(joined({"render", files.volume(), "-o", files.picture, "--mask-as", "tint"}, more));
  };
  check_refused(refusal({}), "name the segmentation by --mask FILE");
  check_refused(refusal({"--mask", files.large, "--mode", "mip"}), "only light through sheets, and slices");
  check_refused(refusal({"--mask", files.large, "--slice", "plane:1,1,0,0"}),
                "an oblique slice shows no labels");
}
