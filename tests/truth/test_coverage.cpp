// How often the sampled error's 95 % interval holds the whole picture's RMSE: the truth of a small picture is
// evaluated once, then 400 samples are drawn from it. On sparse scenes few pixels have most of the error.
#include <fmt/format.h>

#include <algorithm>

#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "truth/sampling.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr int size = 128, draws = 400;
constexpr std::size_t sampled_pixels = 512;

Volume synthesised(const std::string& name) {
  return volume_of(*synth_source(name, make_grid(glm::ivec3(48))));
}

/// A surface two values thick.
TransferFunction thin_surface(double value) {
  TransferFunction tf;
  tf.colours = {{0, {1, 0.8, 0.5}}, {255, {0.5, 0.8, 1}}};
  tf.opacities = {{value - 2, 0}, {value, 0.9}, {value + 2, 0}};
  return tf;
}

struct TestedScene {
  std::string name;
  Volume volume;
  TransferFunction transfer_function;
  Shading shading;
  Camera camera;
};

std::vector<TestedScene> tested_scenes() {
  const Camera camera{.azimuth = 20, .elevation = 10};
  Histogram whole_range(0, 255, 256);
  return {{"head, its surface, unlit", head(), head_preset("mr-surface"), Shading::none, camera},
          {"shell, mr-surface, unlit", synthesised("shell"), preset("mr-surface", whole_range), Shading::none,
           camera},
          {"Gaussians, a thin surface, unlit",
           synthesised("gaussians"),
           thin_surface(100),
           Shading::none,
           {.azimuth = 70, .elevation = 10}},
          {"Marschner-Lobb, mr-surface, lit",
           synthesised("marschner-lobb"),
           preset("mr-surface", whole_range),
           Shading::phong,
           {.azimuth = 40, .elevation = 30}},
          {"jack, grey, lit",
           synthesised("jack"),
           preset("grey", whole_range),
           Shading::phong,
           {.azimuth = 30, .elevation = 30}}};
}

/// A truth of the whole picture: transparent outside its bounds.
Image whole_truth(const truth::Scene& scene, const truth::ScreenBounds& bounds, bool by_method) {
  std::vector<truth::Pixel> pixels;
  for (int y = 0; y < size; ++y)
    for (int x = bounds.rows[std::size_t(y)].first; x < bounds.rows[std::size_t(y)].end; ++x)
      pixels.push_back({x, y});
  const auto colours =
      by_method ? truth::method_truth(scene, pixels) : truth::field_truth(scene, pixels, 1e-5);
  Image image(size, size);
  for (std::size_t k = 0; k < pixels.size(); ++k)
    for (int c = 0; c < 4; ++c) image.pixel(pixels[k].x, pixels[k].y)[c] = static_cast<float>(colours[k][c]);
  return image;
}

std::vector<truth::Rgba> colours_at(const Image& truth, const std::vector<truth::Pixel>& pixels) {
  std::vector<truth::Rgba> colours;
  for (const truth::Pixel p : pixels) {
    const float* c = truth.pixel(p.x, p.y);
    colours.emplace_back(c[0], c[1], c[2], c[3]);
  }
  return colours;
}

struct Coverage {
  int held = 0;
  double mean_square = 0, mean = 0;  ///< means of the estimates
  double median_width = 0;           ///< of the interval, over the true RMSE
};

Coverage coverage_of(const Image& picture, const Image& truth, const truth::ScreenBounds& bounds) {
  const double whole = truth::compare(picture, truth).total.rmse;
  Coverage coverage;
  std::vector<double> widths;
  for (int seed = 0; seed < draws; ++seed) {
    const auto sample = truth::draw_sample(picture, bounds, sampled_pixels, std::uint64_t(seed));
    const auto error = truth::sampled_error(picture, sample, colours_at(truth, sample.pixels));
    constexpr double rounding = 1e-9;
    coverage.held += error.rmse_low <= whole * (1 + rounding) && whole * (1 - rounding) <= error.rmse_high;
    coverage.mean_square += error.rmse * error.rmse / draws;
    coverage.mean += error.mean / draws;
    widths.push_back((error.rmse_high - error.rmse_low) / whole);
  }
  std::nth_element(widths.begin(), widths.begin() + draws / 2, widths.end());
  coverage.median_width = widths[draws / 2];
  return coverage;
}

void check_coverage(bool by_method) {
  for (const TestedScene& s : tested_scenes())
    for (const double zoom : {1.0, 0.3, 0.15}) {
      FrameSpec spec = plain_spec(s.transfer_function, size, s.camera);
      spec.shown.camera.zoom = zoom;
      spec.shown.shading = s.shading;
      const auto source = memory_source(s.volume.grid, s.volume.bytes);
      const Image picture = render_loopback(*source, spec, 1, 1).image;  // with the default opaque threshold
      const truth::Scene scene = scene_of(s.volume, spec);
      const truth::ScreenBounds bounds = by_method ? truth::method_bounds(scene) : truth::field_bounds(scene);
      const Image truth = whole_truth(scene, bounds, by_method);
      const truth::ErrorFigures whole = truth::compare(picture, truth).total;
      const Coverage coverage = coverage_of(picture, truth, bounds);
      INFO(s.name << ", zoom " << zoom << ": " << pixels_of(bounds) << " pixels, RMSE " << whole.rmse
                  << ", median width " << coverage.median_width);
      REQUIRE(whole.rmse > 0);
      CHECK(coverage.held >= 0.93 * draws);
      CHECK(coverage.median_width < 0.5);
      CHECK(coverage.mean_square == Approx(whole.rmse * whole.rmse).epsilon(0.05));
      CHECK(coverage.mean == Approx(whole.mean).margin(0.02 * whole.rmse));
    }
}

}  // namespace

TEST_CASE("against the field the interval holds the whole picture's RMSE in 93 of 100 samples of any scene") {
  check_coverage(false);
}

TEST_CASE(
    "against the method the interval holds the whole picture's RMSE in 93 of 100 samples of any scene") {
  check_coverage(true);
}
