#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "base/output_file.hpp"
#include "base/printable.hpp"
#include "images/image_io.hpp"
#include "program/text_output.hpp"
#include "truth/sampling.hpp"

namespace ringsplat::app {
namespace {

constexpr const char* channel_names[] = {"red", "green", "blue", "alpha"};

/// How far depths are apart, in their own unit, where both pictures have one; and where one alone has.
struct DepthError {
  double rmse = 0, largest = 0;
  std::size_t pixels = 0, alone = 0;
};

DepthError depth_error(const Image::Floats& a, const Image::Floats& b) {
  DepthError e;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    const double apart = std::abs(double(a[k]) - double(b[k]));
    if (std::isinf(apart)) ++e.alone;
    if (!std::isfinite(apart)) continue;
    ++e.pixels;
    e.rmse += apart * apart;
    e.largest = std::max(e.largest, apart);
  }
  e.rmse = std::sqrt(e.rmse / double(e.pixels));
  return e;
}

/// The figures printed for two pictures.
struct Comparison {
  truth::ImageError error;
  int channels;  ///< 3: neither picture has alpha
  std::uint64_t pixels;
  bool linear, failed;
  DepthError depth = {};
};

/// Infinite and undefined figures become null, as JSON has no such numbers.
nlohmann::json to_json(const truth::ErrorFigures& f) {
  return {{"rmse", f.rmse}, {"psnr", f.psnr()},   {"largest", f.largest},
          {"mean", f.mean}, {"over_1", f.over_1}, {"over_2", f.over_2}};
}

std::string to_json_text(const CompareOptions& o, const Comparison& c) {
  auto j = to_json(c.error.total);
  j["a"] = o.a;
  j["b"] = o.b;
  j["values"] = c.linear ? "linear" : "display";
  j["unit"] = "1/255";
  j["largest_at"] = {c.error.worst.x, c.error.worst.y};
  j["threshold"] = o.threshold;
  j["pixels"] = c.pixels;
  j["fraction_over"] = c.error.over_threshold;
  for (int k = 0; k < c.channels; ++k)
    j["channels"][channel_names[k]] = to_json(c.error.channels[std::size_t(k)]);
  if (const auto& d = c.depth; d.pixels + d.alone > 0)
    j["depth"] = {{"rmse", d.rmse}, {"largest", d.largest}, {"pixels", d.pixels}, {"alone", d.alone}};
  j["failed"] = c.failed;
  return plain_json_text(std::move(j), 2);
}

std::string to_text(const CompareOptions& o, const Comparison& c) {
  std::string text = fmt::format("{:<10}{:>12}{:>12}{:>12}{:>12}{:>12}{:>12}\n", "1/255", "RMSE", "PSNR dB",
                                 "largest", "mean", "over 1, %", "over 2, %");
  const auto row = [&](const char* name, const truth::ErrorFigures& f) {
    text += fmt::format("{:<10}{:>12.6g}{:>12.4g}{:>12.6g}{:>+12.4g}{:>12.4g}{:>12.4g}\n", name, f.rmse,
                        f.psnr(), f.largest, plain(f.mean), 100 * f.over_1, 100 * f.over_2);
  };
  row("all", c.error.total);
  for (int k = 0; k < c.channels; ++k) row(channel_names[k], c.error.channels[std::size_t(k)]);
  text += fmt::format(
      "largest at ({}, {}); {:.4g} % of {} pixels differ by more than {:g}/255; {} premultiplied values\n",
      c.error.worst.x, c.error.worst.y, 100 * c.error.over_threshold, c.pixels, o.threshold,
      c.linear ? "linear" : "display (sRGB)");
  if (const auto& d = c.depth; d.pixels + d.alone > 0)
    text += fmt::format("depths: RMSE {:.6g}, largest {:.6g} at {} pixels; {} have one in one picture only\n",
                        d.rmse, d.largest, d.pixels, d.alone);
  return text;
}

/// a − b per channel and scaled, alpha 1, of images of the same size.
void write_difference(const CompareOptions& o, const Image& a, const Image& b) {
  const bool signed_values = std::filesystem::path(o.difference).extension() == ".exr";
  Image picture(a.width, a.height);
  for (std::size_t at = 0; at < picture.rgba.size(); ++at) {
    const auto d = static_cast<float>(o.difference_scale * (double(a.rgba[at]) - double(b.rgba[at])));
    picture.rgba[at] = at % 4 == 3 ? 1.0F : signed_values ? d : std::abs(d);
  }
  // The difference is of the pictures' own values; an 8-bit file's transfer curve must not bend it.
  if (!signed_values)
    picture =
        to_linear({.image = std::move(picture), .linear = false, .has_alpha = false, .settings = {}}).image;
  write_image(picture, o.difference, glm::dvec3(0.0), {});
}

}  // namespace

ExitCode run(const CompareOptions& o) {
  if (!o.difference.empty()) {
    check_image_name(o.difference, "--diff", false);
    check_can_write(o.difference, "--diff");
    refuse_clashes({{"--diff", o.difference}}, {{"a picture", o.a}, {"a picture", o.b}});
  }
  StoredImage a = read_image(o.a), b = read_image(o.b);
  if (a.image.width != b.image.width || a.image.height != b.image.height)
    throw InputError(fmt::format("{} has {}x{} pixels, but {} has {}x{}", o.a, a.image.width, a.image.height,
                                 o.b, b.image.width, b.image.height),
                     "compare pictures of the same size");
  if (a.linear != b.linear) {
    a = to_linear(std::move(a));
    b = to_linear(std::move(b));
  }
  const int channels = a.has_alpha || b.has_alpha ? 4 : 3;
  Comparison c{truth::compare(a.image, b.image, channels, o.threshold), channels,
               std::uint64_t(a.image.width) * std::uint64_t(a.image.height), a.linear, false};
  c.depth = depth_error(a.image.depth, b.image.depth);
  c.failed = o.fail_above && !(c.error.total.rmse <= *o.fail_above);
  write_text_output("-", o.json ? to_json_text(o, c) + "\n" : to_text(o, c));
  if (!o.difference.empty()) write_difference(o, a.image, b.image);
  return c.failed ? ExitCode::comparison_failed : ExitCode::done;
}

}  // namespace ringsplat::app
