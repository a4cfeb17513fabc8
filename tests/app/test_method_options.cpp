// Which method a command line's frame gets, and which combinations of options are refused.
#include "app/parsed.hpp"
#include "app/workshop.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app;
using namespace ringsplat::app_test;

namespace {

CommandLine parse_render(const Words& more) {
  return parsed(joined({"render", "x.nrrd", "-o", "x.png"}, more));
}

FrameSpec frame_of(const std::vector<std::string>& more) {
  const CommandLine line = parse_render(more);
  INFO(line.error);
  REQUIRE(line.error.empty());
  return std::get<RenderOptions>(line.command).frame;
}

Method drawn_by(const std::vector<std::string>& more) { return frame_of(more).how; }

constexpr Sheets draft{.image_plane = ImagePlane::slices, .plane_samples = 1, .slabs = 2, .light_points = 1};
constexpr Sheets normal{
    .image_plane = ImagePlane::slices, .plane_samples = 1.5, .slabs = 2, .light_points = 2};
constexpr Sheets best{.image_plane = ImagePlane::screen, .slabs = 3, .light_points = 2};

}  // namespace

TEST_CASE("a quality stands for a method and its settings") {
  CHECK(drawn_by({}) == drawn_by({"--quality", name(usual_quality)}));
  CHECK(drawn_by({"--quality", "paper"}) == Method(Splats{}));
  CHECK(drawn_by({"--engine", "splats"}) == Method(Splats{}));
  CHECK(drawn_by({"--quality", "draft"}) == Method(draft));
  CHECK(drawn_by({"--quality", "normal"}) == Method(normal));
  CHECK(drawn_by({"--quality", "best"}) == Method(best));
  CHECK(drawn_by({"--engine", "sheets"}) == Method(best));
  CHECK(drawn_by({"--engine", "sheets", "--quality", "draft"}) == Method(draft));
}

TEST_CASE("single options come before a quality's settings") {
  const auto all = drawn_by({"--quality", "best", "--image-plane", "slices", "--samples", "1.5", "--slabs",
                             "4", "--light-points", "1"});
  CHECK(all == Method(Sheets{
                   .image_plane = ImagePlane::slices, .plane_samples = 1.5, .slabs = 4, .light_points = 1}));
  Sheets finer = draft;
  finer.plane_samples = 4;
  CHECK(drawn_by({"--samples", "4", "--quality", "draft"}) == Method(finer));
  // Of a plane that is not used the samples have no trace.
  CHECK(drawn_by({"--quality", "normal", "--image-plane", "screen"}) == Method(Sheets{.slabs = 2}));
  const auto splats =
      drawn_by({"--quality", "paper", "--radius", "1.4", "--image-plane", "slices", "--samples", "2"});
  CHECK(splats ==
        Method(Splats{.image_plane = ImagePlane::slices, .plane_samples = 2, .kernel_radius = 1.4}));
}

TEST_CASE("what every subcommand draws or predicts takes a quality") {
  const CommandLine info = parsed({"info", "x.nrrd", "--ranks", "4", "--quality", "draft"});
  CHECK(std::get<InfoOptions>(info.command).picture.frame.how == Method(draft));
  const CommandLine reference = parsed(
      {"reference", "x.nrrd", "-o", "x.exr", "--truth", "method", "--engine", "sheets", "--slabs", "3"});
  const auto& asked = std::get<ReferenceOptions>(reference.command);
  CHECK(asked.picture.frame.as<Sheets>().slabs == 3);
  CHECK(asked.without_effect.empty());
  const CommandLine field =
      parsed({"reference", "x.nrrd", "-o", "x.exr", "--quality", "best", "--slabs", "3"});
  CHECK(std::get<ReferenceOptions>(field.command).without_effect ==
        std::vector<std::string>{"--quality", "--slabs"});
}

TEST_CASE("a configuration file gives a quality, and the command line comes first") {
  const TemporaryFolder folder;
  write_text(folder / "x.toml", "quality = \"draft\"\nslabs = 3\n");
  Sheets three = draft;
  three.slabs = 3;
  CHECK(drawn_by({"--config", folder / "x.toml"}) == Method(three));
  three = normal;
  three.slabs = 3;
  CHECK(drawn_by({"--config", folder / "x.toml", "--quality", "normal"}) == Method(three));
  const std::string both = parse_render({"--config", folder / "x.toml", "--quality", "paper"}).error;
  CHECK_THAT(both, Catch::Matchers::Contains("--slabs has no effect on splats"));
}

TEST_CASE("options of one engine are refused with the other") {
  const std::vector<std::vector<std::string>> of_splats{{"--radius", "1.5"}};
  const std::vector<std::vector<std::string>> of_sheets{
      {"--slabs", "1"}, {"--light-points", "1"}, {"--samples", "1.5", "--image-plane", "slices"}};
  const auto check_error = [](const Words& words, const std::string& choice, const std::string& value,
                              const std::string& part) {
    const std::string& option = words.front();
    const std::string error = parse_render(joined(words, {choice, value})).error;
    INFO(option << " with " << choice << " " << value << ": " << error);
    CHECK_THAT(error, Catch::Matchers::Contains(option + " has no effect on " + part) &&
                          Catch::Matchers::Contains("hint:"));
  };
  for (const auto& words : of_splats) {
    check_error(words, "--engine", "sheets", "sheets");
    for (const char* quality : {"draft", "normal", "best"})
      check_error(words, "--quality", quality, "sheets");
    CHECK(parse_render(joined(words, {"--quality", "paper"})).error.empty());
  }
  for (const auto& words : of_sheets) {
    check_error(words, "--engine", "splats", "splats");
    check_error(words, "--quality", "paper", "splats");
    CHECK(parse_render(joined(words, {"--engine", "sheets"})).error.empty());
    CHECK(parse_render(words).error.empty());
  }
}

TEST_CASE("qualities, engines and options that contradict each other or do nothing are refused") {
  const std::pair<std::vector<std::string>, const char*> wrong[] = {
      {{"--engine", "splats", "--quality", "best"}, "--engine and --quality contradict"},
      {{"--engine", "sheets", "--quality", "paper"}, "--engine and --quality contradict"},
      {{"--quality", "good"}, "paper|draft|normal|best"},
      {{"--engine", "rays"}, "splats|sheets"},
      {{"--quality", "best", "--samples", "2"}, "--samples has no effect on the screen"},
      {{"--quality", "draft", "--image-plane", "screen", "--samples", "2"},
       "--samples has no effect on the screen"},
      {{"--quality", "best", "--light-points", "1", "--shading", "none"},
       "--light-points has no effect with --shading none"},
      {{"--quality", "paper", "--image-plane", "slices", "--samples", "2.5"}, "--samples cannot be 2.5"},
      {{"--quality", "paper", "--image-plane", "slices", "--samples", "1e300"}, "--samples cannot be 1e+300"},
      {{"--quality", "best", "--slabs", "2.5"}, "--slabs"}};
  for (const auto& [words, part] : wrong) {
    const std::string error = parse_render(words).error;
    INFO(error);
    CHECK_THAT(error, Catch::Matchers::Contains(part));
  }
}

TEST_CASE("an error budget is of sheets, and knows which truth it is kept against") {
  const auto budget = [](const Words& more) {
    const CommandLine line = parse_render(joined({"--max-error", "1"}, more));
    INFO(line.error);
    REQUIRE(line.error.empty());
    return std::get<RenderOptions>(line.command);
  };
  CHECK(budget({"--error", "field"}).budget.to_field);
  for (const Words& words : {Words{}, {"--error", "method"}}) {
    CHECK(budget(words).error.truth == TruthKind::method);
    CHECK_FALSE(budget(words).budget.to_field);
  }
  for (const Words& splats : {Words{"--quality", "paper"}, {"--engine", "splats"}})
    CHECK_THAT(parse_render(joined({"--max-error", "1"}, splats)).error,
               Catch::Matchers::Contains("--max-error has no effect on splats"));
}
