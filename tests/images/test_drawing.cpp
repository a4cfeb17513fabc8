#include "images/drawing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/vec4.hpp>
#include <numeric>

#include "base/srgb.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

const glm::dvec3 white{1}, black{0};

double covered(const Mask& mask) { return std::accumulate(mask.coverage.begin(), mask.coverage.end(), 0.0); }

/// One pixel.
Overlay dot(int x, int y, const glm::vec4& premultiplied) {
  return {{x, y, 1, 1, {premultiplied.x, premultiplied.y, premultiplied.z, premultiplied.w}}};
}

}  // namespace

TEST_CASE("a line covers its length times its thickness, in any direction") {
  for (const glm::dvec2 to : {glm::dvec2(50, 0), glm::dvec2(0, -50), glm::dvec2(30, 40)}) {
    const Mask mask = line_mask({0.5, 0.5}, glm::dvec2(0.5, 0.5) + to, 3);
    CHECK(covered(mask) == Approx(50 * 3 + 3 * 3 * 0.785).epsilon(0.05));
    CHECK(mask.coverage.size() == std::size_t(mask.width) * std::size_t(mask.height));
  }
}

TEST_CASE("a text grows with its letters, and lies above its baseline") {
  const Mask small = text_mask("50 mm", 12), large = text_mask("50 mm", 48);
  CHECK(large.width == Approx(4 * small.width).epsilon(0.15));
  CHECK(covered(large) == Approx(16 * covered(small)).epsilon(0.25));
  CHECK(*std::max_element(large.coverage.begin(), large.coverage.end()) == Approx(1).margin(0.01));
  CHECK(large.y < -30);
  CHECK(large.y + large.height <= 2);
}

TEST_CASE("letters beyond ASCII are not drawn as others") {
  const auto micro = text_mask("\u00b5", 40).coverage;
  for (const char other : std::string("5<C"))  // that parts of its bytes would be
    CHECK(micro != text_mask(std::string(1, other), 40).coverage);
  CHECK(micro.size() > 100);
}

TEST_CASE("a text without ink has no pixels that could be drawn") {
  CHECK(covered(text_mask("", 20)) == 0);
  CHECK(covered(text_mask("  ", 20)) == 0);
}

TEST_CASE("ink has a halo around it, and both together are opaque where the mask is") {
  const Mask mask{10, 20, 1, 1, {1.0F}};
  const Patch patch = inked(mask, white, black, 2);
  REQUIRE(patch.width == 5);
  REQUIRE(patch.x == 8);
  REQUIRE(patch.y == 18);
  const auto pixel = [&](int x, int y) { return patch.rgba.data() + 4 * (5 * y + x); };
  CHECK(pixel(2, 2)[0] == 1);
  CHECK(pixel(2, 2)[3] == 1);
  CHECK(pixel(1, 2)[0] == 0);
  CHECK(pixel(1, 2)[3] == 1);
  CHECK(pixel(0, 0)[3] == 0);
}

TEST_CASE("an overlay makes a transparent picture opaque where it is, and keeps the rest's bytes") {
  std::vector<std::uint8_t> rgba{9, 9, 9, 0, 100, 50, 200, 128, 7, 8, 9, 255};
  const auto before = rgba;
  lay_over(dot(0, 0, {0.2F, 0.4F, 0.6F, 1}), 3, 1, 4, std::span<std::uint8_t>(rgba));
  CHECK(std::vector<int>(rgba.begin(), rgba.begin() + 4) == std::vector<int>{51, 102, 153, 255});
  CHECK(std::equal(rgba.begin() + 4, rgba.end(), before.begin() + 4));
  // Half of white over a half of (100, 50, 200): alpha 1/2 + 1/4, the colours by their shares.
  lay_over(dot(1, 0, {0.5F, 0.5F, 0.5F, 0.5F}), 3, 1, 4, std::span<std::uint8_t>(rgba));
  CHECK(int(rgba[7]) == 192);
  CHECK(std::abs(int(rgba[4]) - (2 * 255 + 100) / 3) <= 1);
}

TEST_CASE("an overlay over linear light is converted to it") {
  std::vector<float> rgb{0.1F, 0.2F, 0.3F};
  lay_over(dot(0, 0, {0.5F, 0.5F, 0.5F, 1}), 1, 1, 3, std::span<float>(rgb));
  CHECK(rgb[0] == Approx(srgb_to_linear(0.5F)));
  std::vector<float> rgba{0.1F, 0.1F, 0.1F, 0.2F};
  lay_over(dot(0, 0, {0.5F, 0.5F, 0.5F, 0.5F}), 1, 1, 4, std::span<float>(rgba));
  CHECK(rgba[0] == Approx(0.5 + 0.05));
  CHECK(rgba[3] == Approx(0.6));
}

TEST_CASE("parts of patches beyond the picture are left out") {
  std::vector<std::uint8_t> rgb(3 * 4, 0);
  const Patch wide{-1, -1, 4, 4, std::vector<float>(4 * 16, 1.0F)};
  lay_over({wide, {5, 0, 1, 1, {1, 1, 1, 1}}, {0, -9, 1, 1, {1, 1, 1, 1}}}, 2, 2, 3,
           std::span<std::uint8_t>(rgb));
  CHECK(std::all_of(rgb.begin(), rgb.end(), [](int b) { return b == 255; }));
}
