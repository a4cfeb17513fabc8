// What sheets cannot resolve, and that the program says so.
#include "options/transfer_function_option.hpp"

#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app;

namespace {

TransferFunction with_opacities(std::vector<TransferFunction::OpacityPoint> points) {
  return {
      .name = "made", .colours = {{0, glm::dvec3(1)}, {1, glm::dvec3(1)}}, .opacities = std::move(points)};
}

}  // namespace

TEST_CASE("labels that are too far apart for sheets to tell them from their neighbours are said") {
  CHECK(why_labels_merge({0, 65535}) == "");
  CHECK_THAT(why_labels_merge({0, 65536}), Catch::Matchers::Contains("--quality paper"));
}

TEST_CASE("more thin layers than sheets resolve are said") {
  const auto layers = [](int count, double half) {
    std::vector<TransferFunction::OpacityPoint> points;
    for (int k = 0; k < count; ++k)
      for (const auto& [beside, opacity] : {std::pair{-half, 0.0}, {0.0, 0.7}, {half, 0.0}})
        points.push_back({(k + 0.5) / count + beside, opacity});
    return with_opacities(points);
  };
  const DataRange unit{0, 1};
  CHECK_THAT(why_sheets_err(layers(14, 0.0004), unit), Catch::Matchers::Contains("14 layers"));
  CHECK(why_sheets_err(layers(14, 0.0006), unit) == "");
  CHECK(why_sheets_err(layers(2, 0.0004), unit) == "");
  CHECK(why_sheets_err(layers(14, 0.0004), {0, 0.1}) == "");
}
