#include "study/error_budget.hpp"

#include "base/archive.hpp"
#include "base/clock.hpp"
#include "base/process.hpp"
#include "truth/certified.hpp"
#include "truth/field.hpp"
#include "truth/method.hpp"
#include "volume/synth.hpp"

namespace ringsplat::app {
namespace {

constexpr Sheets on_screen(int slabs, int light_points) {
  return {.slabs = slabs, .light_points = light_points};
}
constexpr Sheets in_plane(double samples, int slabs, int light_points) {
  return {.image_plane = ImagePlane::slices,
          .plane_samples = samples,
          .slabs = slabs,
          .light_points = light_points};
}
/// From the most exact to the fastest. Each was the fastest within some budget, of 64 combinations, or nearly
/// so (docs/measured/accuracy.md, "Error budgets").
constexpr Shortcuts ladder[] = {{0, on_screen(4, 2)},
                                {1.0 / 512, on_screen(4, 2)},
                                {1.0 / 512, on_screen(3, 2)},
                                {1.0 / 512, on_screen(2, 2)},
                                {1.0 / 128, on_screen(2, 2)},
                                {1.0 / 512, in_plane(2, 2, 2)},
                                {1.0 / 512, in_plane(1.5, 2, 2)},
                                {1.0 / 128, in_plane(1, 2, 2)},
                                {1.0 / 128, in_plane(1.5, 1, 1)},
                                {1.0 / 512, in_plane(1, 1, 1)},
                                {1.0 / 128, in_plane(1, 1, 1)},
                                {1.0 / 32, in_plane(1, 1, 1)},
                                {1.0 / 128, in_plane(1, 1, 1), 2},
                                {1.0 / 128, in_plane(1, 1, 1), 4}};
constexpr double same_time = 1.03;

truth::Rgba colour_of(const float* pixel) { return {pixel[0], pixel[1], pixel[2], pixel[3]}; }

double largest_error(const truth::Rgba& colour, const truth::Rgba& exact) {
  double most = 0;
  for (int c = 0; c < 4; ++c) most = std::max(most, std::abs(truth::levels_apart(colour[c], exact[c])));
  return most;
}

/// Pixels that may err more than `most` become the middle of their bounds. Returns how many.
std::size_t replace_unproved(Image& image, const truth::PixelSample& sample,
                             std::span<const truth::PixelBounds> bounds, double most) {
  std::size_t replaced = 0;
  const auto look = [&](truth::Pixel at, const truth::PixelBounds& proved) {
    float* const pixel = image.pixel(at.x, at.y);
    const truth::Rgba colour = colour_of(pixel);
    if (largest_error(colour, proved.farthest_from(colour)) <= most) return;
    const truth::Rgba middle = proved.middle();
    for (int c = 0; c < 4; ++c) pixel[c] = float(middle[c]);
    ++replaced;
  };
  for (const truth::Pixel at : truth::all_pixels(image.width, image.height))
    if (!sample.bounds.rows[std::size_t(at.y)].contains(at.x)) look(at, {truth::Rgba(0.0), truth::Rgba(0.0)});
  for (std::size_t p = 0; p < bounds.size(); ++p) look(sample.pixels[p], bounds[p]);
  return replaced;
}

/// truth(pixels), for which each of the crew evaluates some.
template <class Truth>
auto together(const Crew& crew, const std::vector<truth::Pixel>& pixels, const Truth& truth) {
  if (!crew.exchange) return truth(pixels);
  constexpr std::size_t piece = 16;  // dealt in turn, as neighbours take similarly long
  const auto is_of = [&](std::size_t member, std::size_t k) { return k / piece % crew.members == member; };
  const std::vector<Bytes> parts = crew.exchange([&] {
    std::vector<truth::Pixel> own;
    for (std::size_t k = 0; k < pixels.size(); ++k)
      if (is_of(crew.member, k)) own.push_back(pixels[k]);
    return to_bytes(truth(own));
  });
  decltype(truth(pixels)) all(pixels.size());
  for (std::size_t member = 0; member < crew.members; ++member) {
    auto part = from_bytes<decltype(all)>(parts.at(member)).value();
    auto next = part.begin();
    for (std::size_t k = 0; k < pixels.size(); ++k)
      if (is_of(member, k)) all[k] = *next++;
  }
  return all;
}

/// How narrow proved bounds are made: a tenth of a level, half of one where light adds its own.
double certified_width(const truth::Scene& scene) { return (scene.shaded() ? 0.5 : 0.1) / truth::levels; }

/// By bounds in place of a truth. The estimate is that of their middles.
MeasuredError measure_certified(Image& image, const truth::Scene& scene, const ErrorOptions& options,
                                std::size_t pixels, const Crew& crew) {
  const auto sample = truth::draw_sample(image, truth::field_bounds(scene), pixels, options.seed);
  const auto bounds = together(crew, sample.pixels, [&](std::span<const truth::Pixel> own) {
    return truth::certified_bounds(scene, own, certified_width(scene));
  });
  std::vector<truth::Rgba> near, middle, far;
  Certificate certificate;
  if (options.guaranteed) certificate.replaced = replace_unproved(image, sample, bounds, *options.guaranteed);
  for (std::size_t p = 0; p < bounds.size(); ++p) {
    const truth::Rgba colour = colour_of(image.pixel(sample.pixels[p].x, sample.pixels[p].y));
    near.push_back(bounds[p].nearest_to(colour));
    middle.push_back(bounds[p].middle());
    far.push_back(bounds[p].farthest_from(colour));
    certificate.widest = std::max(certificate.widest, truth::levels * bounds[p].width());
    const double error = largest_error(colour, far.back());
    for (std::size_t k = 0; k < certificate.limits.size(); ++k)
      certificate.proved[k] += error <= certificate.limits[k];
  }
  if (!bounds.empty())
    for (double& share : certificate.proved) share /= double(bounds.size());
  MeasuredError measured{TruthKind::certified, options.seed, {}, 0};
  const auto least = truth::sampled_error(image, sample, near),
             most = truth::sampled_error(image, sample, far, &measured.by_pixel);
  certificate.least = least.largest;
  truth::SampledError& error = measured.error = truth::sampled_error(image, sample, middle);
  error.rmse_low = least.rmse_low;
  error.rmse_high = most.rmse_high;
  error.largest = most.largest;
  error.worst = most.worst;
  measured.certificate = certificate;
  return measured;
}

}  // namespace

FrameSpec with(FrameSpec frame, const Shortcuts& shortcuts) {
  frame.shown.opaque_threshold = shortcuts.opaque_threshold;
  frame.how = shortcuts.how;
  frame.shown.reduction.factor = shortcuts.undersample;
  return frame;
}

std::string to_text(const Shortcuts& s) {
  std::string text = fmt::format("--opaque-threshold {} --slabs {} --light-points {}", s.opaque_threshold,
                                 s.how.slabs, s.how.light_points);
  if (s.how.image_plane == ImagePlane::slices)
    text += fmt::format(" --image-plane slices --samples {}", s.how.plane_samples);
  if (s.undersample > 1) text += fmt::format(" --undersample {}", s.undersample);
  return text;
}

std::vector<Shortcuts> candidates(const FrameSpec& frame, const ErrorBudgetOptions& o) {
  const Sheets& asked = frame.as<Sheets>();
  const auto fixed = [&o](const char* option) { return o.fixed.contains(option); };
  const double threshold = frame.shown.opaque_threshold;
  std::vector<Shortcuts> all{
      {fixed("--opaque-threshold") ? threshold : 0, asked, frame.shown.reduction.factor}};
  for (const Shortcuts& rung : ladder) {
    Shortcuts s{fixed("--opaque-threshold") ? threshold : rung.opaque_threshold, asked,
                fixed("--undersample") ? all.front().undersample : rung.undersample};
    // More slabs than asked for are nearer to the field, though not to the method.
    if (!fixed("--slabs")) s.how.slabs = o.to_field ? rung.how.slabs : std::min(rung.how.slabs, asked.slabs);
    if (!fixed("--light-points") && frame.shown.shading == Shading::phong)
      s.how.light_points = rung.how.light_points;
    if (!fixed("--image-plane")) {
      s.how.image_plane = rung.how.image_plane;
      s.how.plane_samples = rung.how.plane_samples;
    }
    if (std::ranges::find(all, s) == all.end()) all.push_back(s);
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
  const auto best = std::ranges::min_element(
      measured, {}, [](const MeasuredShortcuts& m) { return std::pair(m.rmse_high, m.seconds); });
  return std::size_t(best - measured.begin());
}

std::optional<Shortcuts> more_exact(std::span<const MeasuredShortcuts> measured, const Shortcuts& used,
                                    double rmse, double max_error, bool last) {
  const auto before = std::ranges::find_if(measured, [&](const auto& m) { return m.shortcuts == used; });
  if (before == measured.end()) return std::nullopt;
  std::vector<MeasuredShortcuts> others;
  for (const auto& m : measured)
    if (m.rmse_high < before->rmse_high) others.push_back(m);
  if (others.empty()) return std::nullopt;
  const auto within = last ? std::nullopt : cheapest_within(others, max_error * before->rmse_high / rmse);
  return others[within.value_or(most_exact(others))].shortcuts;
}

WholeVolume read_whole(VolumeSource& source) {
  const Grid& grid = source.grid();
  const double machine = machine_memory_bytes(), needed = 8.0 * double(grid.voxels());
  if (needed > 0.9 * machine)
    throw InputError(
        fmt::format(
            "a truth needs the whole volume in one process, {:.1f} GiB, but the machine has {:.1f} GiB",
            needed / (1 << 30), machine / (1 << 30)),
        "measure on a smaller volume");
  WholeVolume volume{{grid, truth::read_values(source)}, {}, {}};
  const Pass pass = [&, of_slice = std::ptrdiff_t(grid.slice_voxels(Axis::z))](const RowVisitor& visit) {
    visit_type(grid.type, [&](auto zero) {
      for (auto at = volume.scene.values.begin(); at != volume.scene.values.end(); at += of_slice) {
        const std::vector<decltype(zero)> slice(at, at + of_slice);  // as they were before they were widened
        visit(std::as_bytes(std::span(slice)), grid.dims.x);
      }
    });
  };
  if (VolumeSource* const labels = source.labels()) {
    volume.scene.labels = truth::read_labels(*labels);
    const std::set<double> there(volume.scene.labels.begin(), volume.scene.labels.end());
    volume.labels.assign(there.begin(), there.end());
    std::erase(volume.labels, 0.0);
  }
  volume.statistics = describe_values(grid, source.notes(), pass);
  return volume;
}

std::vector<truth::Rgba> evaluate(const truth::Scene& scene, const Evaluation& e,
                                  std::span<const truth::Pixel> pixels) {
  if (e.truth == TruthKind::method) return truth::method_truth(scene, pixels);
  if (e.truth == TruthKind::field) return truth::field_truth(scene, pixels, e.tolerance);
  if (e.truth == TruthKind::certified) {
    std::vector<truth::Rgba> middles;
    for (const auto& bounds : truth::certified_bounds(scene, pixels, certified_width(scene)))
      middles.push_back(bounds.middle());
    return middles;
  }
  return truth::analytic_truth(scene, synth_field(e.formula), truth::synth_scale(scene.grid.type), pixels,
                               e.tolerance);
}

SampledTruth sample_truth(const Image& picture, const truth::Scene& scene, const Evaluation& evaluation,
                          std::size_t pixels, std::uint64_t seed, const Crew& crew) {
  const auto bounds =
      evaluation.truth == TruthKind::method ? truth::method_bounds(scene) : truth::field_bounds(scene);
  SampledTruth made{truth::draw_sample(picture, bounds, pixels, seed), {}};
  made.colours = together(crew, made.sample.pixels, [&](std::span<const truth::Pixel> own) {
    return evaluate(scene, evaluation, own);
  });
  return made;
}

TruthKind calibrating_truth(const ErrorOptions& options) {
  const TruthKind truth = options.truth.value_or(TruthKind::method);
  return truth == TruthKind::certified ? TruthKind::field : truth;
}

MeasuredError measure(Image& image, const truth::Scene& scene, const ErrorOptions& options,
                      const Crew& crew) {
  const double start = now_seconds();
  const std::size_t pixels = options.all ? image.rgba.size() / 4 : options.pixels;
  MeasuredError measured{*options.truth, options.seed, {}, 0};
  if (options.truth == TruthKind::certified) {
    measured = measure_certified(image, scene, options, pixels, crew);
  } else {
    const auto [sample, colours] = sample_truth(image, scene, {*options.truth}, pixels, options.seed, crew);
    measured.error = truth::sampled_error(image, sample, colours, &measured.by_pixel);
  }
  measured.seconds = now_seconds() - start;
  return measured;
}

std::string to_text(const MeasuredError& m) {
  if (m.certificate) {
    const Certificate& c = *m.certificate;
    const std::string replaced =
        c.replaced ? fmt::format("; {} pixels replaced by the middle of their bounds", *c.replaced) : "";
    return fmt::format(
        "error certified against the field: at most {:.4g}/255 (somewhere at least {:.4g}), {:.4g} to {:.4g} "
        "rms; "
        "proved within 0.5, 1 and 2: {:.4g}, {:.4g} and {:.4g} %; bounds at most {:.3g} wide; {} pixels in "
        "{:.2f} s{}",
        m.error.largest, c.least, m.error.rmse_low, m.error.rmse_high, 100 * c.proved[0], 100 * c.proved[1],
        100 * c.proved[2], c.widest, m.error.pixels, m.seconds, replaced);
  }
  return fmt::format(
      "error against the {}'s truth: {:.4g}/255 rms (95 %: {:.4g} to {:.4g}), largest {:.4g}, mean {:+.3g}; "
      "{} pixels in {:.2f} s",
      name(m.truth), m.error.rmse, m.error.rmse_low, m.error.rmse_high, m.error.largest, plain(m.error.mean),
      m.error.pixels, m.seconds);
}

}  // namespace ringsplat::app
