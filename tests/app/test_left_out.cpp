// What the program says in builds without OpenImageIO; other builds have none of these tests.
#include "app/program_runner.hpp"
#include "ringsplat/config.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;
using Catch::Matchers::Contains;

namespace {

/// The arguments must be refused in one line that names the file and the option that brings what is missing.
[[maybe_unused]] void check_refused(const std::vector<std::string>& arguments, const std::string& file,
                                    const std::string& option) {
  const Ended ended = run_program(arguments);
  CAPTURE(file, ended.err);
  CHECK(ended.code == 2);
  CHECK(lines_with(ended.err, "").size() == 1);
  CHECK_THAT(ended.err, Contains(file) && Contains("-D" + option + "=ON"));
}

}  // namespace

#if !RINGSPLAT_WITH_OPENIMAGEIO
TEST_CASE("a build without OpenImageIO refuses what that reads and writes, and says how to have it") {
  const TemporaryFolder folder;
  REQUIRE(run_program({"synth", "shell", "-o", folder / "shell.nrrd", "--dims", "16"}).code == 0);
  for (const std::string name : {"a.exr", "a.tif", "a.jpg"})
    check_refused({"render", folder / "shell.nrrd", "-o", folder / name}, name, "RINGSPLAT_WITH_OPENIMAGEIO");
  check_refused({"render", folder / "shell.nrrd", "-o", folder / "a.png", "--annotate"}, "",
                "RINGSPLAT_WITH_OPENIMAGEIO");
  write_text(folder / "stack.tif", "II*");
  check_refused({"info", folder / "stack.tif"}, "stack.tif", "RINGSPLAT_WITH_OPENIMAGEIO");
  CHECK(files_in(folder.path()) == 2);
}

TEST_CASE("a build without OpenImageIO writes a PNG and compares it") {
  const TemporaryFolder folder;
  REQUIRE(run_program({"synth", "shell", "-o", folder / "shell.nrrd", "--dims", "16"}).code == 0);
  for (const std::string quality : {"best", "paper"})
    REQUIRE(run_program({"render", folder / "shell.nrrd", "-o", folder / (quality + ".png"), "--quality",
                         quality, "--size", "64"})
                .code == 0);
  CHECK(run_program({"compare", folder / "best.png", folder / "best.png", "--fail-above", "0"}).code == 0);
  CHECK(run_program({"compare", folder / "best.png", folder / "paper.png", "--fail-above", "0"}).code == 1);
}
#endif
