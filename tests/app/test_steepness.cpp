// Which transfer functions are too steep for splats, and that the program says so.
#include "options/transfer_function_option.hpp"

#include "app/program_runner.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app;
using namespace ringsplat::app_test;

namespace {

ValueRange range_from(double low, double high) {
  ValueRange range;
  range.low = low;
  range.high = high;
  range.finite = 1;
  return range;
}

TransferFunction with_opacities(std::vector<TransferFunction::OpacityPoint> points) {
  return {
      .name = "made", .colours = {{0, glm::dvec3(1)}, {1, glm::dvec3(1)}}, .opacities = std::move(points)};
}

double steepness_of(const std::string& name, double low, double high) {
  return steepness(preset(name, Histogram(low, high, 16)), range_from(low, high));
}

}  // namespace

TEST_CASE("steepness is the largest change of opacity within a 64th of the values' range") {
  const ValueRange unit = range_from(0, 1);
  CHECK(steepness(with_opacities({{0, 0}, {1, 0.64}}), unit) == Approx(0.01));
  CHECK(steepness(with_opacities({{0, 0}, {0.5, 0.1}, {0.6, 0.74}, {1, 0.8}}), unit) == Approx(0.1));
  CHECK(steepness(with_opacities({{0, 0.9}, {0.5, 0.9}, {0.5, 0.2}, {1, 0.2}}), unit) == Approx(0.7));
  CHECK(steepness(with_opacities({{0, 0}, {0.5, 0}, {0.501, 0.8}, {0.502, 0}, {1, 0}}), unit) == Approx(0.8));
  // A steep part that no value reaches counts for nothing, and a step beyond the range does not either.
  CHECK(steepness(with_opacities({{0, 0}, {10, 0}, {10, 1}}), unit) == 0);
  CHECK(steepness(with_opacities({{-5, 0}, {-5, 1}, {1, 1}}), unit) == 0);
  CHECK(steepness(with_opacities({{0, 0}, {1, 1}}), range_from(3, 3)) == 0);
  CHECK(steepness(with_opacities({{-1e308, 0}, {1e308, 0.64}}), range_from(-1e308, 1e308)) == Approx(0.01));
}

TEST_CASE("steep surfaces and bone are said to err with splats, soft presets are not") {
  const auto errs = [](const std::string& name, double low, double high) {
    return why_splats_err(preset(name, Histogram(low, high, 16)), range_from(low, high));
  };
  for (const char* gentle : {"mr-soft", "mr-skin", "grey"}) CHECK(errs(gentle, 0, 255) == "");
  const std::string surface = errs("mr-surface", 0, 255), bone = errs("ct-bone", -1000, 3000);
  CHECK_THAT(surface, Catch::Matchers::Contains("about 11/255") &&
                          Catch::Matchers::Contains("'mr-surface'") &&
                          Catch::Matchers::Contains("--quality best"));
  CHECK_THAT(bone, Catch::Matchers::Contains("about 9/255"));
  CHECK(errs("ct-bone", -1000, 0) == "");  // a volume without bone
  CHECK(steepness_of("mr-soft", 0, 255) < 0.02);
  CHECK(steepness_of("mr-surface", 0, 4095) == Approx(steepness_of("mr-surface", 0, 1)));
}

TEST_CASE("labels that are too far apart for sheets to tell them from their neighbours are said") {
  CHECK(why_labels_merge(range_from(0, 65535)) == "");
  CHECK_THAT(why_labels_merge(range_from(0, 65536)), Catch::Matchers::Contains("--quality paper"));
}

TEST_CASE("more thin layers than sheets resolve are said") {
  const auto layers = [](int count, double half) {
    std::vector<TransferFunction::OpacityPoint> points;
    for (int k = 0; k < count; ++k)
      for (const auto& [beside, opacity] : {std::pair{-half, 0.0}, {0.0, 0.7}, {half, 0.0}})
        points.push_back({(k + 0.5) / count + beside, opacity});
    return with_opacities(points);
  };
  const ValueRange unit = range_from(0, 1);
  CHECK_THAT(why_sheets_err(layers(14, 0.0004), unit), Catch::Matchers::Contains("14 layers"));
  CHECK(why_sheets_err(layers(14, 0.0006), unit) == "");
  CHECK(why_sheets_err(layers(2, 0.0004), unit) == "");
  CHECK(why_sheets_err(layers(14, 0.0004), range_from(0, 0.1)) == "");
}

TEST_CASE("a steep picture is warned of once, by rank 0, where splats draw it and nobody measures",
          "[mpi][openimageio]") {
  const TemporaryFolder folder;
  const std::string volume = folder / "volume.nrrd";
  REQUIRE(run_program({"synth", "gaussians", "--dims", "12x12x12", "-o", volume}).code == 0);
  const auto warnings = [&](const std::vector<std::string>& more, int ranks) {
    std::vector<std::string> all{"render", volume, "-o", folder / "x.png", "--size", "24", "--orbit", "2"};
    all.insert(all.end(), more.begin(), more.end());
    const Ended ended = run_program(all, ranks);
    INFO(ended.err);
    CHECK(ended.code == 0);
    return lines_with(ended.err, "is steep").size();
  };
  CHECK(warnings({"--tf", "mr-surface", "--quality", "paper"}, 0) == 1);
  CHECK(warnings({"--tf", "mr-surface", "--engine", "splats"}, 3) == 1);
  CHECK(warnings({"--tf", "mr-soft", "--quality", "paper"}, 0) == 0);
  CHECK(warnings({"--tf", "mr-surface", "--quality", "paper", "--error", "method"}, 0) == 0);
  CHECK(warnings({"--tf", "mr-surface"}, 0) == 0);
}
