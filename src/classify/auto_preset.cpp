#include "classify/auto_preset.hpp"

#include <fmt/format.h>

#include "base/printable.hpp"
#include "classify/value_shape.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

constexpr double haze = 0.05;

std::string percent(double share) { return fmt::format("{:.3g} %", 100 * share); }

/// "values 0 to 255 but for 1 voxel outside (up to 1e+30)".
std::string described(const Data& d) {
  std::string text = fmt::format("values {:g} to {:g}", plain(d.low()), plain(d.high()));
  if (d.fill_below || d.fill_above)
    text += fmt::format(" but for {:g} in {} of the voxels, which is left clear",
                        d.fill_below ? *d.fill_below : *d.fill_above, percent(d.filled / d.all));
  if (d.outside > 0)
    text += fmt::format(" but for {:.0f} voxel{} far outside ({} {:g})", d.outside, d.outside == 1 ? "" : "s",
                        d.outlier < d.low() ? "down to" : "up to", d.outlier);
  return text;
}

/// Display colours from common values to rare ones.
struct Ramp {
  const char* name;
  std::array<glm::dvec3, 4> colours;
};

/// Patients have the colours of tissue; of all else no colour may say what it is, so that brightness alone
/// grows evenly: viridis from a quarter on, as darker colours are lost in front of black.
const Ramp& ramp_for(World world) {
  static const Ramp warm{"warm ramp",
                         {{{0.35, 0.12, 0.10}, {0.78, 0.40, 0.26}, {0.95, 0.76, 0.54}, {1.0, 0.96, 0.88}}}};
  static const Ramp neutral = [] {
    Ramp ramp{"viridis", {}};
    const auto points = colour_map(ramp.name).points;
    for (std::size_t k = 0; k < 4; ++k) ramp.colours[k] = points[(k + 1) * (points.size() - 1) / 4].srgb;
    return ramp;
  }();
  return world == World::patient ? warm : neutral;
}

/// Gives the values of the function's opacities, from the `first` on, the ramp's colours.
void lay(const Ramp& ramp, TransferFunction& tf, std::size_t first = 0) {
  for (std::size_t k = 0; k < ramp.colours.size(); ++k)
    tf.colours.push_back({tf.opacities[first + k].value, ramp.colours[k]});
}

AutoChoice even_haze(const ValueStatistics& s) {
  const DataRange range = range_of(s.histogram);
  TransferFunction tf;
  const glm::dvec3 colour = ramp_for(s.notes.world).colours[2];
  tf.colours = {{range.low, colour}, {range.high, colour}};
  tf.opacities = {{range.low, haze}, {range.high, haze}};
  return {tf, fmt::format("every voxel is {:g}: an even haze", plain(s.range.low)), false, range};
}

/// The optical depth of a way through the object, as thick as its visible voxels would be in one piece.
double optical_depth(const TransferFunction& tf, const Data& d) {
  double depth = 0, visible = 0;
  for (const ValueBin& bin : d.bins) {
    const double opacity = std::min(tf.evaluate(bin.middle()).opacity, 0.999);
    if (!(opacity > 0)) continue;
    visible += double(bin.count);
    depth -= std::log1p(-opacity) * double(bin.count);
  }
  if (visible == 0) return 0;
  return depth / visible * d.depth * std::cbrt(visible / d.all);
}

/// Scales opacities so that a way through the object neither shows next to nothing nor its surface alone.
void balance(TransferFunction& tf, const Data& d) {
  constexpr double least = 1.5, most = 25;
  for (int round = 0; round < 4; ++round) {
    const double depth = optical_depth(tf, d);
    if (depth <= 0 || (depth >= least && depth <= most)) return;
    scale_opacity(tf, std::clamp(depth, least, most) / depth);
  }
}

/// Clear where the fill value and outliers are.
void clear_outside(TransferFunction& tf, const Data& d) {
  const double span = d.high() - d.low();
  if (d.fill_below) clear_below(tf, beside(*d.fill_below, {d.low(), d.high()}));
  if (d.fill_above) clear_above(tf, beside(*d.fill_above, {d.low(), d.high()}));
  if (d.outside_below && !d.fill_below) clear_below(tf, d.low() - span);
  if (d.outside_above && !d.fill_above) clear_above(tf, d.high() + span);
}

// CT

std::optional<AutoChoice> choose_ct(const ValueStatistics& s, const Data& d) {
  const bool said = s.notes.modality == "CT" && d.low() < -200 && d.high() > 100;
  const double air = share_within(d.bins, -1100, -850), soft = share_within(d.bins, -150, 250),
               between = share_within(d.bins, -600, -250), bone = share_within(d.bins, 300, 1e5);
  const bool of_its_range = s.range.low <= -900 && s.range.low >= -4096 && s.range.high > 1000 &&
                            s.range.high < 70000 && air > 0.03 && soft > 0.03 && between < soft;
  if (!said && !of_its_range) return std::nullopt;
  const char* const name = bone > soft ? "ct-bone" : "ct-soft";
  return AutoChoice{
      .function = preset(name, s.histogram),
      .why = fmt::format("CT in Hounsfield units ({}): preset {}",
                         said ? "modality CT" : "by its range and the shares of air and soft tissue", name),
      .range = {-1000, 1500},
      .hounsfield = true};
}

// both signs

/// The bins of |v|, ascending.
Bins magnitudes(const Bins& bins) {
  Bins all;
  for (const ValueBin& bin : bins) {
    const double a = std::abs(bin.low), b = std::abs(bin.high);
    all.push_back({bin.low < 0 && bin.high > 0 ? 0 : std::min(a, b), std::max(a, b), bin.count});
  }
  std::sort(all.begin(), all.end(), [](const ValueBin& a, const ValueBin& b) { return a.high < b.high; });
  return all;
}

std::optional<AutoChoice> choose_signed(const Data& d) {
  if (!(d.low() < 0 && d.high() > 0)) return std::nullopt;
  const double a = -upper_quantile(d.bins, 0.001), b = upper_quantile(d.bins, 0.999);
  const double most = std::max(a, b), median = upper_quantile(d.bins, 0.5);
  const double negative = share_within(d.bins, -std::numeric_limits<double>::infinity(), -0.02 * most),
               positive = share_within(d.bins, 0.02 * most, std::numeric_limits<double>::infinity());
  if (std::min(a, b) < 0.25 * most || std::abs(median) > 0.1 * most ||
      std::min(negative, positive) < 0.1 * std::max(negative, positive))
    return std::nullopt;
  Bins sizes = magnitudes(d.bins);
  std::erase_if(sizes, [&](const ValueBin& bin) { return bin.high <= 0.02 * most; });
  const double scale = std::max(upper_quantile(sizes, 0.9999), most);
  const double gap = 0.03 * scale;
  const double clear = std::min(std::max(upper_quantile(sizes, 0.5), 0.05 * scale), 0.6 * scale);
  const double common = std::max(upper_quantile(sizes, 0.85), clear + gap);
  const double rare = std::max(upper_quantile(sizes, 0.97), common + gap);
  const double end = std::max(scale, rare + gap);
  TransferFunction tf;
  tf.opacities = {{-end, 0.7},  {-rare, 0.3},   {-common, haze}, {-clear, 0.0},
                  {clear, 0.0}, {common, haze}, {rare, 0.3},     {end, 0.7}};
  tf.colours = colours_over(colour_map("coolwarm"), {-end, end});
  balance(tf, d);
  return AutoChoice{tf,
                    fmt::format("{}, both signs about zero: diverging colours, clear from {:.3g} to {:.3g}",
                                described(d), -clear, clear),
                    false,
                    {-end, end}};
}

// many decades

/// A bin that holds 0 reaches to the least positive numbers, by which zeros would count as these.
Bins positive_of(Bins bins) {
  constexpr double least = std::numeric_limits<float>::min();
  std::erase_if(bins, [](const ValueBin& bin) { return !(bin.middle() >= least); });
  return bins;
}

std::optional<AutoChoice> choose_logarithmic(const Data& d, const Ramp& ramp) {
  if (d.low() < 0) return std::nullopt;
  const Bins positive = positive_of(d.bins);
  if (positive.size() < 8) return std::nullopt;
  const double high = upper_quantile(positive, 0.999), low = upper_quantile(positive, 0.01),
               median = upper_quantile(positive, 0.5);
  const double few = share_within(positive, 0.1 * high, std::numeric_limits<double>::infinity());
  if (!(low > 0) || high < 1000 * low || high < 100 * median || few > 0.05) return std::nullopt;
  const double top = positive.back().high;
  TransferFunction tf;
  tf.opacities = {{median, 0.0},
                  {upper_quantile(positive, 0.85), haze},
                  {upper_quantile(positive, 0.98), 0.3},
                  {top, 0.7}};
  lay(ramp, tf);
  tf = at_logarithmic_steps(tf);
  balance(tf, d);
  return AutoChoice{tf,
                    fmt::format("{} over {:.0f} decades, mostly small: {} at logarithmic steps from {:.3g}",
                                described(d), std::log10(top / low), ramp.name, median),
                    false,
                    {median, top}};
}

// all else

/// Scales what is as opaque as a plateau and less, so that a way through the plateau alone is not opaque.
void thin_out(TransferFunction& tf, const Plateau& plateau, const Data& d) {
  const double opacity = tf.evaluate(plateau.value).opacity;
  const double depth = -std::log1p(-std::min(opacity, 0.999)) * d.depth * std::cbrt(plateau.voxels / d.all);
  constexpr double most = 1.0;
  if (!(depth > most)) return;
  for (auto& point : tf.opacities)
    if (point.opacity <= opacity) point.opacity *= most / depth;
  const TransferFunction::OpacityPoint at{plateau.value, opacity * most / depth};
  const auto next = std::ranges::find_if(tf.opacities, [&](const auto& p) { return p.value > at.value; });
  tf.opacities.insert(next, at);
}

AutoChoice choose_generic(const Data& d, const Ramp& ramp) {
  Foreground f = find_foreground(d);
  const auto plateau = flatten_plateaus(f.bins, d.all);
  const double sign = f.upward ? 1 : -1, span = d.high() - d.low(), gap = 0.02 * span;
  const auto share = [&](double s) {
    if (f.upward) return upper_quantile(f.bins, s);
    for (auto bin = f.bins.rbegin(); bin != f.bins.rend(); ++bin)
      if ((s -= double(bin->count) / count_of(f.bins)) <= 1e-12) return bin->low;
    return f.bins.front().low;
  };
  const double edge = f.edge, end = f.upward ? d.high() : d.low(), behind = f.upward ? d.low() : d.high();
  const auto away = [&](double wanted, double before, double part) {
    const double least = before + sign * std::min(gap, part * std::abs(end - before));
    return f.upward ? std::clamp(wanted, std::min(least, end), end)
                    : std::clamp(wanted, end, std::max(least, end));
  };
  const double common = away(share(0.5), edge, 0.3), rare = away(share(0.9), common, 0.5);
  TransferFunction tf;
  tf.opacities = {{behind, 0.0}, {edge, 0.0}, {common, haze}, {rare, 0.3}, {end, 0.7}};
  lay(ramp, tf, 1);
  if (!f.upward) {
    std::reverse(tf.opacities.begin(), tf.opacities.end());
    std::reverse(tf.colours.begin(), tf.colours.end());
  }
  if (plateau) thin_out(tf, *plateau, d);
  balance(tf, d);
  std::string why = described(d);
  if (f.background) why += fmt::format(", background {} {:.4g}", f.upward ? "below" : "above", plain(edge));
  if (plateau)
    why +=
        fmt::format(", {} of the voxels at {:.4g}", percent(plateau->voxels / d.all), plain(plateau->value));
  why += fmt::format(": {} from {:.4g} to {:.4g}", ramp.name, plain(edge), plain(end));
  return {tf, why, false, f.upward ? DataRange{edge, end} : DataRange{end, edge}};
}

/// Well separated in CIE Lab, none of them dark: chosen as by Glasbey et al. 2007 ("Colour displays for
/// categorical images"), each as far as possible from all before it.
constexpr std::array<std::uint32_t, 64> palette{
    0xe13c3c, 0x00ff00, 0x780fff, 0xffd200, 0x0096ff, 0x1effd2, 0xff3cc3, 0x4b690f, 0xffc396, 0x874b78,
    0x0096a5, 0xb4f069, 0xf0d2ff, 0x965ae1, 0x965a00, 0xff7800, 0x96c396, 0xff87a5, 0x00ff87, 0x009600,
    0xf01eff, 0xff0078, 0xa5695a, 0xf096f0, 0xc3b44b, 0x96f0ff, 0xff0000, 0x7887b4, 0x00965a, 0xa5ff1e,
    0x3c694b, 0xb41e78, 0x00c3ff, 0x5a5ab4, 0x004bff, 0xf0a52d, 0xf0875a, 0xe1f000, 0xb400b4, 0x0069f0,
    0xa59669, 0xb42d4b, 0x78a52d, 0x3cd21e, 0x78e187, 0x00c3b4, 0xa596ff, 0xe1f096, 0xf069ff, 0xc387a5,
    0xa54ba5, 0xb43c00, 0x962de1, 0xb4c31e, 0xffb4b4, 0x87781e, 0x00ffff, 0x87b4ff, 0xff69b4, 0x1e6987,
    0xff5a78, 0xa54b2d, 0x785a2d, 0xd2964b};

AutoChoice labelled(const std::vector<double>& labels, const char* reason) {
  const auto count = std::count_if(labels.begin(), labels.end(), [](double v) { return v != 0; });
  return {label_function(labels),
          fmt::format("{} label{} ({}): a colour each, 0 clear", count, count == 1 ? "" : "s", reason),
          true,
          {labels.front() - 0.5, labels.back() + 0.5}};
}

}  // namespace

DataRange range_of(const Histogram& histogram) {
  double low = histogram.low, high = histogram.high;
  if (!std::isfinite(low) || !std::isfinite(high) || low > high) return {0.0, 1.0};
  if (low < high) return {low, high};
  constexpr double most = std::numeric_limits<double>::max();
  const double reach = std::max(1.0, std::abs(low));
  return {low > reach - most ? low - reach : -most, high < most - reach ? high + reach : most};
}

glm::dvec3 label_colour(double label) {
  const double count = double(palette.size());
  const double place = std::fmod(label - 1, count);
  return colour_of(palette[std::size_t(place < 0 ? place + count : place)]);
}

TransferFunction label_function(const std::vector<double>& labels) {
  TransferFunction tf;
  tf.name = "labels";
  double end = std::numeric_limits<double>::quiet_NaN();
  for (const double label : labels) {
    if (label == 0) continue;
    const double low = label - 0.5, high = label + 0.5;
    const glm::dvec3 colour = label_colour(label);
    tf.colours.insert(tf.colours.end(), {{low, colour}, {high, colour}});
    if (low == end)
      tf.opacities.back() = {high, label_opacity};
    else {
      if (!tf.opacities.empty()) tf.opacities.push_back({end, 0.0});
      tf.opacities.insert(tf.opacities.end(), {{low, 0.0}, {low, label_opacity}, {high, label_opacity}});
    }
    end = high;
  }
  if (tf.opacities.empty()) {
    tf.colours = {{0, glm::dvec3(1.0)}, {1, glm::dvec3(1.0)}};
    tf.opacities = {{0, 0.0}, {1, 0.0}};
    return tf;
  }
  tf.opacities.push_back({end, 0.0});
  return tf;
}

AutoChoice choose_labels(const ValueStatistics& s) {
  if (s.labels.empty())
    throw InputError(
        fmt::format("the volume's values are no labels: they are not whole numbers, or more than {} "
                    "different ones",
                    DistinctValues::most),
        "leave out --labels");
  if (s.labels.size() == 1 && s.labels.front() == 0)
    throw InputError("the volume has no label: every voxel is 0, which is background",
                     "choose another volume");
  return labelled(s.labels, "--labels");
}

AutoChoice choose_within(const ValueStatistics& s, const DataRange& window, bool logarithmic) {
  Data d = data_of(s);
  std::erase_if(d.bins,
                [&](const ValueBin& bin) { return bin.middle() < window.low || bin.middle() > window.high; });
  // Places on the axis, 0 to 1.
  const auto place = [&](double value) {
    const double part = logarithmic ? std::log(value / window.low) / std::log(window.high / window.low)
                                    : (value - window.low) / (window.high - window.low);
    return std::isfinite(part) ? std::clamp(part, 0.0, 1.0) : 0.5;
  };
  const auto value = [&](double part) { return logarithmic ? window.at_logarithm(part) : window.at(part); };
  const double common = std::clamp(place(upper_quantile(d.bins, 0.5)), 0.1, 0.8);
  const double rare = std::clamp(place(upper_quantile(d.bins, 0.9)), common + 0.05, 0.95);
  TransferFunction tf;
  tf.name = "auto";
  tf.opacities = {{window.low, 0.0}, {value(common), haze}, {value(rare), 0.3}, {window.high, 0.7}};
  const Ramp& ramp = ramp_for(s.notes.world);
  lay(ramp, tf);
  if (logarithmic) tf = at_logarithmic_steps(tf);
  balance(tf, d);
  return {tf,
          fmt::format("{} from {:.4g} to {:.4g}{}", ramp.name, plain(window.low), plain(window.high),
                      logarithmic ? " at logarithmic steps" : ""),
          false, window};
}

DataRange positive_range(const ValueStatistics& s) {
  const Bins positive = positive_of(s.bins.empty() ? Bins{} : data_of(s).bins);
  if (positive.empty())
    throw InputError(fmt::format("--log needs positive values, but the volume's run from {:g} to {:g}",
                                 plain(s.range.low), plain(s.range.high)),
                     "leave out --log");
  const double high = positive.back().high;
  double low = positive.back().middle();
  double seen = 0;
  for (const ValueBin& bin : positive)
    if ((seen += double(bin.count)) >= 0.01 * count_of(positive)) {
      low = std::max(bin.low, bin.middle() / 2);
      break;
    }
  return {low, high > low ? high : 2 * low};
}

AutoChoice choose_function(const ValueStatistics& s) {
  const bool single = s.bins.empty() || !(s.range.low < s.range.high);
  AutoChoice choice;
  if (single) {
    choice = even_haze(s);
  } else if (s.labels.size() > 1 && (s.notes.labels || look_like_labels(s))) {
    choice = labelled(s.labels, s.notes.labels ? "the file says so" : "few whole numbers in pieces");
  } else {
    const Data d = data_of(s);
    if (const auto ct = choose_ct(s, d))
      choice = *ct;
    else if (const auto diverging = choose_signed(d))
      choice = *diverging;
    else if (const auto logarithmic = choose_logarithmic(d, ramp_for(s.notes.world)))
      choice = *logarithmic;
    else
      choice = choose_generic(d, ramp_for(s.notes.world));
    clear_outside(choice.function, d);
  }
  choice.function.name = "auto";
  return choice;
}

}  // namespace ringsplat
