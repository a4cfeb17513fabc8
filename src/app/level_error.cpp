#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/common.hpp>
#include <limits>

#include "app/frame_output.hpp"
#include "classify/adjust.hpp"
#include "classify/piecewise.hpp"
#include "truth/field.hpp"
#include "truth/sampling.hpp"
#include "volume/clipped.hpp"

namespace ringsplat::app {
namespace {

/// As dense by `factor`. Opacity is a line between points, which does not scale: points in between do.
void scale_density(TransferFunction& tf, double factor) {
  tf.opacities = with_more(tf.opacities, [&](auto& all, std::size_t k) {
    const auto &a = tf.opacities[k], &b = tf.opacities[k + 1];
    for (double part = 1.0 / 64; part < 1; part += 1.0 / 64)
      all.push_back({std::lerp(a.value, b.value, part), std::lerp(a.opacity, b.opacity, part)});
  });
  scale_opacity(tf, factor);
}

}  // namespace

std::string level_error(const Image& picture, const truth::Scene& shown, const RenderOptions& options) {
  if (!std::filesystem::is_directory(options.volume.path)) return {};
  VolumeOptions volume = options.volume;
  volume.choice.memory = std::numeric_limits<double>::infinity();
  const Grid finest = open_volume(volume)->grid();
  const glm::ivec3 coarser = glm::ivec3(glm::round(shown.grid.spacing / finest.spacing));
  if (finest.dims == shown.grid.dims || glm::any(glm::lessThan(coarser, glm::ivec3(1)))) return {};

  constexpr double enough = 1 << 27;
  const double most = std::min(enough, options.volume.choice.memory.value_or(enough)) / sizeof(double);
  truth::Scene level = shown;
  level.poll = {};  // which tells how far the picture's own error is
  VoxelBox part = shown.frame.shown.clip.value_or(whole_box(shown.grid));
  const glm::dvec3 dims(part.dims()), fine_dims = dims * glm::dvec3(coarser);
  const double kept = std::cbrt(std::min(1.0, most / (fine_dims.x * fine_dims.y * fine_dims.z)));
  part.first += glm::ivec3(0.5 * (1 - kept) * dims);
  part.end = part.first + glm::max(glm::ivec3(kept * dims), 1);
  level.frame.shown.clip = part;
  const VoxelBox of_finest = box_in_finest(part, coarser, finest.dims);
  const auto source = open_volume(part_of(volume, of_finest));
  truth::Scene fine{source->grid(), truth::read_values(*source), shown.frame};
  if (VolumeSource* const labels = source->labels()) fine.labels = truth::read_labels(*labels);
  // The camera fits the level, whose last voxels may reach beyond the finest's.
  fine.cut_from = {{shown.grid.dims * coarser, finest.spacing, finest.origin, finest.direction},
                   of_finest.first};
  fine.frame.shown.clip.reset();
  scale_density(fine.frame.shown.transfer_function, finest.unit_length() / shown.grid.unit_length());

  const auto sample =
      truth::draw_sample(picture, truth::field_bounds(level), options.error.pixels, options.error.seed);
  Image of_level(picture.width, picture.height);
  const auto colours = truth::field_truth(level, sample.pixels);
  for (std::size_t k = 0; k < colours.size(); ++k)
    for (int c = 0; c < 4; ++c)
      of_level.pixel(sample.pixels[k].x, sample.pixels[k].y)[c] = float(colours[k][c]);
  const auto error = truth::sampled_error(of_level, sample, truth::field_truth(fine, sample.pixels));
  return fmt::format(
      "this level of the pyramid against the finest: {:.4g}/255 rms (95 %: {:.4g} to {:.4g}), "
      "largest {:.4g}; {} pixels of the middle, {} of the finest's voxels",
      error.rmse, error.rmse_low, error.rmse_high, error.largest, error.pixels,
      detail::product_of(fine.grid.dims));
}

}  // namespace ringsplat::app
