#include "app/error_budget.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace ringsplat::app {
namespace {

/// Left out are table and fixed-point kernels and other normalisations: none is ever both cheaper and nearer
/// to the requested method's truth (docs/accuracy.md, "Speed against error").
constexpr double opaque_thresholds[] = {0, 1.0 / 512, 1.0 / 128, 1.0 / 32};
constexpr Precision precisions[] = {Precision::float32, Precision::half, Precision::u8};
/// On the screen only: in the slices' plane a smaller kernel reaches as many pixels.
constexpr double smaller_radii[] = {1.5, 1.4, 1.2};
constexpr int samples_a_voxel[] = {2, 1};
constexpr int undersampling[] = {2, 4};

constexpr double same_time = 1.03;

const char* word(Precision precision) {
  return precision == Precision::float32 ? "float" : precision == Precision::half ? "half" : "u8";
}

/// The sets of radius, image plane and level to choose from.
std::vector<Shortcuts> geometries(const FrameSpec& frame, const ErrorBudgetOptions& o) {
  const Shortcuts given{frame.shown.opaque_threshold,     frame.as<Splats>().precision,
                        frame.as<Splats>().kernel_radius, frame.as<Splats>().image_plane,
                        frame.as<Splats>().plane_samples, frame.shown.reduction.factor};
  std::vector<Shortcuts> all{given};
  const auto add = [&](auto Shortcuts::*what, auto value) {
    all.push_back(all.front());
    all.back().*what = value;
  };
  if (!o.fixed_radius && frame.as<Splats>().image_plane == ImagePlane::screen) {
    for (const double radius : smaller_radii)
      if (radius < frame.as<Splats>().kernel_radius) add(&Shortcuts::radius, radius);
  }
  Shortcuts coarsest = given;
  if (!o.fixed_image_plane) {
    coarsest.plane = ImagePlane::slices;
    for (const int samples : samples_a_voxel) {
      coarsest.samples = samples;
      all.push_back(coarsest);
    }
  }
  if (!o.fixed_undersample) {
    for (const int factor : undersampling) {
      coarsest.undersample = factor;
      all.push_back(coarsest);
    }
  }
  return all;
}

}  // namespace

FrameSpec with(FrameSpec frame, const Shortcuts& shortcuts) {
  frame.shown.opaque_threshold = shortcuts.opaque_threshold;
  frame.as<Splats>().precision = shortcuts.precision;
  frame.as<Splats>().kernel_radius = shortcuts.radius;
  frame.as<Splats>().image_plane = shortcuts.plane;
  frame.as<Splats>().plane_samples = shortcuts.samples;
  frame.shown.reduction.factor = shortcuts.undersample;
  return frame;
}

std::vector<int> levels_to_choose_from() {
  std::vector<int> factors{1};
  factors.insert(factors.end(), std::begin(undersampling), std::end(undersampling));
  return factors;
}

std::string to_text(const Shortcuts& s) {
  std::string text = fmt::format("--opaque-threshold {} --precision {} --radius {}", s.opaque_threshold,
                                 word(s.precision), s.radius);
  if (s.plane == ImagePlane::slices) text += fmt::format(" --image-plane slices --samples {}", s.samples);
  if (s.undersample > 1) text += fmt::format(" --undersample {}", s.undersample);
  return text;
}

std::vector<Shortcuts> candidates(const FrameSpec& frame, const ErrorBudgetOptions& o) {
  std::vector<double> thresholds{frame.shown.opaque_threshold};
  std::vector<Precision> forms{frame.as<Splats>().precision};
  if (!o.fixed_opaque_threshold)
    thresholds.assign(std::begin(opaque_thresholds), std::end(opaque_thresholds));
  if (!o.fixed_precision && frame.as<Splats>().payload == PayloadForm::runs)
    forms.assign(std::begin(precisions), std::end(precisions));
  std::vector<Shortcuts> all;
  for (Shortcuts s : geometries(frame, o)) {
    for (const Precision precision : forms) {
      for (const double threshold : thresholds) {
        s.precision = precision;
        s.opaque_threshold = threshold;
        all.push_back(s);
      }
    }
  }
  return all;
}

std::optional<std::size_t> cheapest_within(std::span<const MeasuredShortcuts> measured, double max_error) {
  std::optional<double> least;
  for (const auto& m : measured)
    if (m.rmse_high <= max_error) least = std::min(least.value_or(m.seconds), m.seconds);
  if (!least) return std::nullopt;
  std::optional<std::size_t> best;
  for (std::size_t k = 0; k < measured.size(); ++k) {
    const auto& m = measured[k];
    if (!(m.rmse_high <= max_error && m.seconds <= *least * same_time)) continue;
    if (!best || m.rmse_high < measured[*best].rmse_high) best = k;
  }
  return best;
}

std::size_t most_exact(std::span<const MeasuredShortcuts> measured) {
  const auto best = std::min_element(measured.begin(), measured.end(), [](const auto& a, const auto& b) {
    return a.rmse_high != b.rmse_high ? a.rmse_high < b.rmse_high : a.seconds < b.seconds;
  });
  return std::size_t(best - measured.begin());
}

}  // namespace ringsplat::app
