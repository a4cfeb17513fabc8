#include "options/transfer_function_option.hpp"

#include "session/render_frames.hpp"
#include "volume/scalars.hpp"

namespace ringsplat::app {
namespace {

/// From black to a channel's colour. Without light the steps are even on the display, as microscopes'
/// programs show them; what is seen through haze would be too dark in that way. A surface has one colour.
ColourMap map_to(const glm::dvec3& colour, Mode mode) {
  const int steps = mode == Mode::composite ? 1 : 32;
  ColourMap map{.name = "channel", .points = {}};
  for (int k = 0; k <= steps; ++k) {
    const double part = double(k) / steps;
    map.points.push_back({part, mode == Mode::surface ? colour : part * colour});
  }
  return map;
}

/// Voxels of the file's fill value are clear whatever the function says.
void clear_noted_fill(TransferFunction& tf, const ValueStatistics& values) {
  const auto& fill = values.notes.fill;
  if (!fill || values.fill_voxels == 0 || !(tf.evaluate(*fill).opacity > 0)) return;
  if (*fill < values.range.low)
    clear_below(tf, beside(*fill, {values.range.low, values.range.high}));
  else if (*fill > values.range.high)
    clear_above(tf, beside(*fill, {values.range.low, values.range.high}));
  else
    clear_at(tf, *fill, is_whole(values.grid.type));
}

/// In single slices, which have no depth.
void show_labels(Shown& shown) {
  shown.mode = Mode::composite;
  shown.shading = Shading::none;
  for (auto& point : shown.transfer_function.opacities) point.opacity = point.opacity == 0 ? 0 : 1;
}

}  // namespace

TransferFunctionChoice::TransferFunctionChoice(const std::string& text, const ColourOptions& colour)
    : colour_(colour) {
  if (!colour_.colours.empty()) map_ = colour_map(colour_.colours);
  if (colour_.tint) map_ = map_to(*colour_.tint, colour_.mode);
  const auto presets = detail::mapped(preset_names(), &PresetName::name);
  if (std::find(presets.begin(), presets.end(), text) != presets.end()) {
    preset_ = text;
    return;
  }
  std::error_code ignored;
  if (std::filesystem::exists(text, ignored)) {
    from_file_ = read_transfer_function(text, &ramp_);
    return;
  }
  if (text.find('/') != std::string::npos || std::filesystem::path(text).has_extension())
    throw InputError(fmt::format("--tf {} is no file that can be read", text),
                     "check the path, or use a preset: ringsplat info --presets");
  const std::string alike = closest(text, presets);
  throw InputError(fmt::format("--tf {} is neither a preset nor a file", text),
                   (alike.empty() ? "" : fmt::format("did you mean {}? ", alike)) +
                       fmt::format("the presets are {}", joined(presets, ", ")));
}

AutoChoice TransferFunctionChoice::base(const ValueStatistics& values) const {
  if (colour_.labels) return choose_labels(values);
  const bool is_auto = !from_file_ && preset_ == "auto";
  const bool windowed = colour_.range || colour_.log || colour_.values;
  if (is_auto && !windowed && (colour_.mode == Mode::composite || colour_.slice)) {
    const AutoChoice chosen = choose_function(values);
    if (chosen.labels || !colour_.slice) return chosen;
  }
  DataRange window{0, 1};
  if (colour_.log) window = positive_range(values);
  if (colour_.range) window = *colour_.range;
  if (colour_.values) window = {values.range.low, values.range.high};
  if (is_auto && colour_.mode != Mode::composite)
    return choose_for_mode(colour_.mode, values, windowed ? std::optional(window) : std::nullopt);
  if (is_auto) return choose_within(values, window, colour_.log);
  AutoChoice made;
  made.function = from_file_ ? *from_file_ : preset(preset_, values.histogram);
  made.range = windowed ? window : ends_of(made.function);
  if (windowed) stretch(made.function, window);
  if (colour_.log) made.function = on_logarithmic_axis(made.function);
  return made;
}

MadeFunction TransferFunctionChoice::make(const ValueStatistics& values, Shown& shown) const {
  check_values(values, "check the file's --type and --endian");
  if (colour_.log && colour_.range && !(colour_.range->low > 0))
    throw InputError(fmt::format("--log cannot show values from {:g}, as only positive ones have a logarithm",
                                 colour_.range->low),
                     "give --range a LO above 0");
  AutoChoice made = base(values);
  auto& tf = made.function;
  if (map_) {
    tf.colours = colours_over(*map_, made.range);
    if (colour_.log) tf.colours = on_logarithmic_axis(tf.colours);
  }
  if (colour_.log) clear_below(tf, std::numeric_limits<double>::denorm_min());
  // A voxel of a pyramid's coarser level is as dense as those of the finest that it stands for.
  if (const double denser = colour_.opacity * values.coarseness(); denser != 1) scale_opacity(tf, denser);
  clear_noted_fill(tf, values);
  std::string said = made.why.empty() || colour_.values ? "" : fmt::format("--tf auto: {}", made.why);
  if (ramp_)
    said = fmt::format("--tf {}: the file has no opacities, so a ramp from clear at {:g} to opaque at {:g}",
                       tf.name, plain(made.range.low), plain(made.range.high));
  shown.isovalue = 0;
  if (colour_.mode == Mode::surface) {
    shown.isovalue = colour_.isovalue ? *colour_.isovalue : parting_value(values);
    if (!colour_.isovalue)
      said = fmt::format("--isovalue: {:.6g} parts the volume's values best", shown.isovalue);
  }
  shown.transfer_function = std::move(made.function);
  const Interpolation usual = made.labels ? Interpolation::nearest : Interpolation::linear;
  shown.interpolation = colour_.interpolation.value_or(usual);
  shown.mode = colour_.mode;
  if (made.labels && colour_.slice) show_labels(shown);
  shown.values = colour_.values;
  shown.holes = values.range.not_finite > 0;
  return {said, made.labels};
}

std::string list_of_colour_maps() {
  std::string text;
  for (const auto& map : colour_map_names()) text += fmt::format("{:<22}{}\n", map.name, map.description);
  return text;
}

std::string why_sheets_err(const TransferFunction& tf, const DataRange& range) {
  // One or two thin layers get nodes of their own.
  constexpr int nodes = 1020, resolved = 2;
  const double thin = (range.high / nodes) - (range.low / nodes);
  int layers = 0;
  for (std::size_t i = 1; i + 1 < tf.opacities.size(); ++i) {
    const auto &before = tf.opacities[i - 1], &peak = tf.opacities[i], &behind = tf.opacities[i + 1];
    if (peak.opacity > before.opacity && peak.opacity > behind.opacity && peak.value >= range.low &&
        peak.value <= range.high && behind.value - before.value < thin)
      ++layers;
  }
  if (layers <= resolved) return {};
  return fmt::format(
      "transfer function '{}' has {} layers thinner than 1/{} of the values' range, more than can be "
      "resolved: they are drawn wider and fainter; hint: make them wider, or leave only {}",
      tf.name, layers, nodes, resolved);
}

std::string why_labels_merge(const DataRange& range) {
  constexpr double told_apart = 65535;
  if (!(range.high - range.low > told_apart)) return {};
  return fmt::format(
      "values run from {:.10g} to {:.10g}, of which sheets tell {:.0f} apart: neighbouring labels may have "
      "each other's colours; hint: --quality paper tells all apart",
      range.low, range.high, told_apart + 1);
}

}  // namespace ringsplat::app
