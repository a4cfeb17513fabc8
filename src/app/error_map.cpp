#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/annotation.hpp"
#include "app/frame_output.hpp"
#include "classify/colour_maps.hpp"
#include "images/image_io.hpp"
#include "program/text_output.hpp"

namespace ringsplat::app {

void write_error_map(const MeasuredError& error, const Image& picture, const std::filesystem::path& file,
                     const std::string& settings) {
  // A few pixels often err many times more than all others.
  constexpr double of_rmse = 10, least = 1e-3;
  const double top = round_length(std::clamp(of_rmse * error.error.rmse, least, truth::levels));
  constexpr const char* colours = "inferno";
  TransferFunction tf{colours, colour_map(colours).points, {{0, 1}, {top, 1}}};
  for (auto& point : tf.colours) point.value *= top;
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
