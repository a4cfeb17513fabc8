#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "app/image_difference.hpp"
#include "app/output_file.hpp"
#include "ringsplat/app/image_io.hpp"

namespace ringsplat::app {
namespace {

constexpr const char* channel_names[] = {"red", "green", "blue", "alpha"};

/// Infinite and undefined figures become null, as JSON has no such numbers.
nlohmann::json to_json(const Difference& d) {
  return {{"rmse", d.rmse}, {"psnr", d.psnr()}, {"largest", d.largest}, {"mean", d.mean}};
}

std::string to_json_text(const CompareOptions& o, const ImageDifference& d, bool linear, bool failed) {
  auto j = to_json(d.total);
  j["a"] = o.a;
  j["b"] = o.b;
  j["values"] = linear ? "linear" : "display";
  j["unit"] = "1/255";
  j["largest_at"] = {d.largest_x, d.largest_y};
  j["threshold"] = o.threshold;
  j["pixels"] = d.pixels;
  j["pixels_over"] = d.pixels_over;
  j["fraction_over"] = d.fraction_over();
  for (int c = 0; c < d.channel_count; ++c)
    j["channels"][channel_names[c]] = to_json(d.channels[std::size_t(c)]);
  j["failed"] = failed;
  return j.dump(2);
}

std::string to_text(const CompareOptions& o, const ImageDifference& d, bool linear) {
  std::string text =
      fmt::format("{:<10}{:>12}{:>12}{:>12}{:>12}\n", "1/255", "RMSE", "PSNR dB", "largest", "mean");
  const auto row = [&](const char* name, const Difference& x) {
    text += fmt::format("{:<10}{:>12.6g}{:>12.4g}{:>12.6g}{:>+12.4g}\n", name, x.rmse, x.psnr(), x.largest,
                        x.mean);
  };
  row("all", d.total);
  for (int c = 0; c < d.channel_count; ++c) row(channel_names[c], d.channels[std::size_t(c)]);
  text += fmt::format(
      "largest at ({}, {}); {} of {} pixels ({:.4g} %) differ by more than {:g}/255; {} premultiplied "
      "values\n",
      d.largest_x, d.largest_y, d.pixels_over, d.pixels, 100 * d.fraction_over(), o.threshold,
      linear ? "linear" : "display (sRGB)");
  return text;
}

void write_difference(const CompareOptions& o, const Image& a, const Image& b) {
  const bool signed_values = std::filesystem::path(o.difference).extension() == ".exr";
  // The difference lies in the pictures' own values, which an 8-bit file's transfer curve must not bend.
  Image picture = difference_image(a, b, o.difference_scale, !signed_values);
  if (!signed_values)
    picture =
        to_linear({.image = std::move(picture), .linear = false, .has_alpha = false, .settings = {}}).image;
  write_image(picture, o.difference, glm::dvec3(0.0), {});
}

}  // namespace

ExitCode run_compare(const CompareOptions& o) {
  if (!std::isfinite(o.difference_scale) || std::isnan(o.threshold) || std::isnan(o.fail_above.value_or(0)))
    throw InputError("--diff-scale, --threshold and --fail-above must be numbers",
                     "for instance --threshold 1");
  if (!o.difference.empty()) {
    check_image_name(o.difference, "--diff", false);
    check_can_write(o.difference, "--diff");
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
  const ImageDifference d = difference(a.image, b.image, a.has_alpha || b.has_alpha ? 4 : 3, o.threshold);
  const bool failed = o.fail_above && !(d.total.rmse <= *o.fail_above);
  fmt::print("{}", o.json ? to_json_text(o, d, a.linear, failed) + "\n" : to_text(o, d, a.linear));
  if (!o.difference.empty()) write_difference(o, a.image, b.image);
  return failed ? ExitCode::comparison_failed : ExitCode::done;
}

}  // namespace ringsplat::app
