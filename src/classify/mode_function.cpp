#include <fmt/format.h>

#include <algorithm>

#include "base/printable.hpp"
#include "classify/auto_preset.hpp"
#include "classify/colour_maps.hpp"
#include "classify/value_shape.hpp"

namespace ringsplat {
namespace {

/// The mean of what is no outlier.
double mean_of(const Bins& bins) {
  double sum = 0;
  for (const ValueBin& bin : bins) sum += bin.middle() * double(bin.count);
  return sum / count_of(bins);
}

/// What a mode's values lie within, as far as the voxels' values tell.
DataRange window_of(Mode mode, const Data& d, const Grid& grid) {
  if (mode == Mode::mip || mode == Mode::attenuated) {
    // A ray's largest value is a rare one, and it looks black where all are background.
    const Foreground f = find_foreground(d);
    constexpr double all_but_few = 0.9999;
    return {f.background && f.upward ? f.edge : d.low(), upper_quantile(d.bins, all_but_few)};
  }
  if (mode != Mode::mean && mode != Mode::sum) return {d.low(), d.high()};
  // Rays through the object's middle have a few times the mean of the whole volume.
  constexpr double times = 2.5;
  const glm::dvec3 size = grid.spacing * glm::dvec3(grid.dims);
  const double mean = mean_of(d.bins), low = mode == Mode::sum ? std::min(d.low(), 0.0) : d.low(),
               length = mode == Mode::sum ? std::max({size.x, size.y, size.z}) : 1;
  return {low * length, (low + times * (mean - low)) * length};
}

}  // namespace

const char* name(Mode mode) {
  constexpr const char* names[] = {"composite", "mip", "minip", "mean", "sum", "surface", "attenuated"};
  return names[static_cast<int>(mode)];
}

AutoChoice choose_for_mode(Mode mode, const ValueStatistics& values, const std::optional<DataRange>& window) {
  DataRange range = range_of(values.histogram);
  if (window)
    range = *window;
  else if (!values.bins.empty() && values.range.low < values.range.high)
    range = window_of(mode, data_of(values), values.grid);
  if (!(range.low < range.high)) range.high = range.low + std::max(1.0, 1e-6 * std::abs(range.low));
  const glm::dvec3 bone{0.95, 0.86, 0.74}, stone{0.8, 0.8, 0.8},
      even = values.notes.world == World::patient ? bone : stone;
  AutoChoice choice;
  choice.function.name = "auto";
  if (mode == Mode::surface)
    choice.function.colours = {{range.low, even}, {range.high, even}};
  else
    choice.function.colours = colours_over(colour_map("gray"), range);
  choice.function.opacities = {{range.low, 1.0}, {range.high, 1.0}};
  if (mode == Mode::attenuated) choice.function.opacities = {{range.low, 0.0}, {range.high, 0.05}};
  choice.range = range;
  constexpr const char* shown[] = {"",
                                   "largest values",
                                   "least values",
                                   "means",
                                   "integrals over length",
                                   "",
                                   "largest values, dimmed by what lies before them"};
  if (mode != Mode::surface)
    choice.why = fmt::format("{}, black at {:.4g} to white at {:.4g}", shown[static_cast<int>(mode)],
                             plain(range.low), plain(range.high));
  return choice;
}

double parting_value(const ValueStatistics& values) {
  if (values.bins.empty()) return 0;
  const Bins bins = data_of(values).bins;
  const double all = count_of(bins), mean = mean_of(bins);
  double below = 0, sum_below = 0, most_apart = -1, value = bins.front().high;
  for (std::size_t k = 0; k + 1 < bins.size(); ++k) {
    below += double(bins[k].count);
    sum_below += bins[k].middle() * double(bins[k].count);
    const double above = all - below;
    if (!(below > 0 && above > 0)) continue;
    const double apart = sum_below - mean * below, between = apart * apart / (below * above);
    if (between > most_apart) most_apart = between, value = 0.5 * (bins[k].high + bins[k + 1].low);
  }
  return value;
}

}  // namespace ringsplat
