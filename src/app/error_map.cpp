#include "app/error_map.hpp"

#include <nlohmann/json.hpp>

#include "images/image_io.hpp"
#include "program/text_output.hpp"

namespace ringsplat::app {
namespace {

constexpr const char* colours = "inferno";

/// From 0 up to what few pixels exceed: these often err many times more than all others.
TransferFunction colours_of(const MeasuredError& error) {
  constexpr double of_rmse = 10, least = 1e-3;
  const double top = round_length(std::clamp(of_rmse * error.error.rmse, least, truth::levels));
  TransferFunction tf{colours, colour_map(colours).points, {{0, 1}, {top, 1}}};
  for (auto& point : tf.colours) point.value *= top;
  return tf;
}

Image map_of(const MeasuredError& error, const Image& picture, const TransferFunction& tf) {
  Image map(picture.width, picture.height);
  for (std::size_t p = 0; p < error.by_pixel.size(); ++p) {
    if (std::isnan(error.by_pixel[p])) continue;
    const double shown = std::min(double(error.by_pixel[p]), tf.colours.back().value);
    const glm::dvec3 colour = tf.evaluate(shown).colour;
    for (int c = 0; c < 3; ++c) map.rgba[4 * p + std::size_t(c)] = float(colour[c]);
    map.rgba[4 * p + 3] = 1;
  }
  return map;
}

}  // namespace

void write_error_map(const MeasuredError& error, const Image& picture, const std::filesystem::path& file,
                     const std::string& settings) {
  const TransferFunction tf = colours_of(error);
  const double top = tf.colours.back().value;
  auto all = nlohmann::json::parse(settings);
  all["error_map"] = {{"colours", colours}, {"from", 0}, {"to", top}, {"unit", "1/255"}};
  write_image(map_of(error, picture, tf), file, std::nullopt, plain_json_text(std::move(all)),
              colour_bar(picture.width, picture.height, tf, {0, top}, "error in 1/255"));
}

serve::ProvedErrors proved_errors(const Job& job, const FrameResult& picture, int volume,
                                  const std::function<void()>& go_on) {
  if (!job.channels.empty())
    throw InputError("errors are proved of one channel, not of several", "start it with one --channel");
  truth::Scene scene = read_whole(*open_volume(job.part(std::size_t(volume)))).scene;
  scene.frame = picture.spec;
  scene.poll = [&](double) { go_on(); };
  Image image = picture.image;
  const MeasuredError error = measure(image, scene, {.truth = TruthKind::certified, .all = true});
  const TransferFunction tf = colours_of(error);
  return {
      fmt::format("No pixel of {} x {} errs more than {:.3g}/255, {:.3g} % at most 1. Proved in {:.1f} s.",
                  image.width, image.height, error.error.largest, 100 * error.certificate->proved[1],
                  error.seconds),
      tf, image_bytes(map_of(error, image, tf), ".png", std::nullopt, {})};
}

}  // namespace ringsplat::app
