#include <glm/geometric.hpp>

#include "classify/paraview_curves.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

void require_close(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
  INFO(a.x << ' ' << a.y << ' ' << a.z << "  expected  " << b.x << ' ' << b.y << ' ' << b.z);
  REQUIRE(glm::distance(a, b) <= tolerance);
}

constexpr glm::dvec3 black{0, 0, 0}, white{1, 1, 1}, red{1, 0, 0}, blue{0, 0, 1};

}  // namespace

TEST_CASE("other names than ParaView's are no colour spaces") {
  REQUIRE(colour_curve("Step", false) == nullptr);
}

TEST_CASE("every space meets the two colours at its ends") {
  const glm::dvec3 a{0.2, 0.7, 0.4}, b{0.9, 0.3, 0.6};
  for (const auto* const space : {"HSV", "Lab", "CIELAB", "Diverging"})
    for (const bool wrap : {false, true}) {
      INFO(space);
      require_close(colour_curve(space, wrap)(a, b, 0), a,
                    2e-3);  // Lab's published matrices have four digits
      require_close(colour_curve(space, wrap)(a, b, 1), b, 2e-3);
    }
}

TEST_CASE("HSV runs through the hues, wrapped the short way round") {
  require_close(colour_curve("HSV", false)(red, blue, 0.5), {0, 1, 0}, 1e-12);
  require_close(colour_curve("HSV", true)(red, blue, 0.5), {1, 0, 1}, 1e-12);
  require_close(colour_curve("HSV", true)(blue, red, 0.5), {1, 0, 1}, 1e-12);
  require_close(colour_curve("HSV", false)(black, white, 0.25), glm::dvec3(0.25), 1e-12);
}

TEST_CASE("Lab: half way from black to white is lightness 50") {
  require_close(colour_curve("Lab", false)(black, white, 0.5), glm::dvec3(0.46633), 1e-3);
}

TEST_CASE("Diverging gives Moreland's published cool to warm map") {
  const glm::dvec3 cool = glm::dvec3(59, 76, 192) / 255.0, warm = glm::dvec3(180, 4, 38) / 255.0;
  // Moreland 2009, the table published with the paper, in 8-bit colours.
  require_close(colour_curve("Diverging", false)(cool, warm, 0.25), glm::dvec3(141, 176, 254) / 255.0, 0.01);
  require_close(colour_curve("Diverging", false)(cool, warm, 0.5), glm::dvec3(221, 221, 221) / 255.0, 0.01);
  require_close(colour_curve("Diverging", false)(cool, warm, 0.75), glm::dvec3(244, 152, 122) / 255.0, 0.01);
}
