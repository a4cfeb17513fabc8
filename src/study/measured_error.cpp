#include "study/measured_error.hpp"

#include <fmt/format.h>

#include "base/clock.hpp"
#include "base/printable.hpp"
#include "base/process.hpp"
#include "ringsplat/base/error.hpp"
#include "truth/field.hpp"
#include "truth/method.hpp"
#include "volume/synth.hpp"

namespace ringsplat::app {
WholeVolume read_whole(VolumeSource& source) {
  const Grid& grid = source.grid();
  const double machine = machine_memory_bytes(), needed = 8.0 * double(grid.voxels());
  if (needed > 0.9 * machine)
    throw InputError(
        fmt::format(
            "a truth needs the whole volume in one process, {:.1f} GiB, but the machine has {:.1f} GiB",
            needed / (1 << 30), machine / (1 << 30)),
        "measure on a smaller volume");
  WholeVolume volume{{grid, truth::read_values(source)}, {}};
  const auto bytes = std::as_bytes(std::span(volume.scene.values));
  const VolumeNotes notes = source.notes();
  const Pass pass = [&](const RowVisitor& visit) { visit(bytes, grid.dims.x); };
  Merging alone;
  volume.statistics =
      describe_values({grid.type, notes.fill, ScalarType::float64}, grid.dims, notes, pass, alone);
  return volume;
}

std::vector<truth::Rgba> evaluate(const truth::Scene& scene, const Evaluation& e,
                                  std::span<const truth::Pixel> pixels) {
  if (e.truth == TruthKind::method) return truth::method_truth(scene, pixels);
  if (e.truth == TruthKind::field) return truth::field_truth(scene, pixels, e.tolerance);
  return truth::analytic_truth(scene, synth_field(e.formula), truth::synth_scale(scene.grid.type), pixels,
                               e.tolerance);
}

SampledTruth sample_truth(const Image& picture, const truth::Scene& scene, const Evaluation& evaluation,
                          std::size_t pixels, std::uint64_t seed) {
  const auto bounds =
      evaluation.truth == TruthKind::method ? truth::method_bounds(scene) : truth::field_bounds(scene);
  SampledTruth made{truth::draw_sample(picture, bounds, pixels, seed), {}};
  made.colours = evaluate(scene, evaluation, made.sample.pixels);
  return made;
}

MeasuredError measure(const Image& image, const truth::Scene& scene, const ErrorOptions& options) {
  const double start = now_seconds();
  const auto [sample, colours] = sample_truth(image, scene, {*options.truth}, options.pixels, options.seed);
  return {*options.truth, options.seed, truth::sampled_error(image, sample, colours), now_seconds() - start};
}

std::string to_text(const MeasuredError& m) {
  return fmt::format(
      "error against the {}'s truth: {:.4g}/255 rms (95 %: {:.4g} to {:.4g}), largest {:.4g}, mean {:+.3g}; "
      "{} pixels in {:.2f} s",
      to_string(m.truth), m.error.rmse, m.error.rmse_low, m.error.rmse_high, m.error.largest,
      plain(m.error.mean), m.error.pixels, m.seconds);
}

}  // namespace ringsplat::app
