#include "app/error_map.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/annotation.hpp"
#include "classify/colour_maps.hpp"
#include "images/image_io.hpp"
#include "program/text_output.hpp"

namespace ringsplat::app {
namespace {

constexpr const char* colours = "inferno";

/// A round number that hardly any error exceeds: a few pixels often err many times more than all others.
double top_of(std::vector<float> errors) {
  std::erase_if(errors, [](float e) { return !std::isfinite(e); });
  constexpr double most_pixels = 0.998, least = 1e-3;
  if (errors.empty()) return least;
  const auto at = errors.begin() + std::ptrdiff_t(most_pixels * double(errors.size() - 1));
  std::nth_element(errors.begin(), at, errors.end());
  constexpr double largest_step = 2.5;  // from one round length to the next
  return round_length(largest_step * std::max(double(*at), least));
}

TransferFunction colours_to(double top) {
  TransferFunction tf{
      .name = colours, .colours = colour_map(colours).points, .opacities = {{0, 1}, {top, 1}}};
  for (auto& point : tf.colours) point.value *= top;
  return tf;
}

}  // namespace

void write_error_map(const MeasuredError& error, const Image& picture, const std::filesystem::path& file,
                     const std::string& settings) {
  const double top = top_of(error.by_pixel);
  const TransferFunction tf = colours_to(top);
  Image map(picture.width, picture.height);
  for (std::size_t p = 0; p < error.by_pixel.size(); ++p) {
    if (std::isnan(error.by_pixel[p])) continue;
    const glm::dvec3 colour = tf.evaluate(std::min(double(error.by_pixel[p]), top)).colour;
    for (int c = 0; c < 3; ++c) map.rgba[4 * p + std::size_t(c)] = float(colour[c]);
    map.rgba[4 * p + 3] = 1;
  }
  auto all = nlohmann::json::parse(settings);
  all["error_map"] = {{"colours", colours}, {"from", 0}, {"to", top}, {"unit", "1/255"}};
  write_image(map, file, std::nullopt, plain_json_text(std::move(all)),
              colour_bar(map.width, map.height, tf, {0, top}, "error in 1/255"));
}

}  // namespace ringsplat::app
