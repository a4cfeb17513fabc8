#include "app/transfer_function_option.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "app/option_values.hpp"
#include "base/printable.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

std::vector<std::string> names_of_presets() {
  std::vector<std::string> names;
  for (const auto& preset : preset_names()) names.push_back(preset.name);
  return names;
}

bool looks_like_a_file(const std::string& text) {
  return text.find('/') != std::string::npos || std::filesystem::path(text).has_extension();
}

/// The range of values from where the opacity first leaves zero to where it last returns to it.
std::string visible_range(const TransferFunction& tf) {
  const auto visible = [](const TransferFunction::OpacityPoint& p) { return p.opacity > 0; };
  const auto first = std::find_if(tf.opacities.begin(), tf.opacities.end(), visible);
  if (first == tf.opacities.end()) return "nowhere";
  const auto last = std::find_if(tf.opacities.rbegin(), tf.opacities.rend(), visible).base() - 1;
  const double from = first == tf.opacities.begin() ? first->value : (first - 1)->value;
  const double to = last + 1 == tf.opacities.end() ? last->value : (last + 1)->value;
  return fmt::format("from {:g} to {:g}", plain(from), plain(to));
}

}  // namespace

TransferFunctionChoice::TransferFunctionChoice(const std::string& text) {
  const auto presets = names_of_presets();
  if (std::find(presets.begin(), presets.end(), text) != presets.end()) {
    preset_ = text;
    return;
  }
  std::error_code ignored;
  if (std::filesystem::exists(text, ignored)) {
    from_file_ = read_transfer_function(text);
    return;
  }
  if (looks_like_a_file(text))
    throw InputError(fmt::format("--tf {} is no file that can be read", text),
                     "check the path, or use a preset: ringsplat info --presets");
  const std::string alike = closest(text, presets);
  throw InputError(fmt::format("--tf {} is neither a preset nor a file", text),
                   (alike.empty() ? "" : fmt::format("did you mean {}? ", alike)) +
                       fmt::format("the presets are {}", joined(presets, ", ")));
}

TransferFunction TransferFunctionChoice::make(const Histogram& histogram) const {
  return from_file_ ? *from_file_ : preset(preset_, histogram);
}

std::string why_nothing_is_visible(const TransferFunction& tf, const ValueRange& range,
                                   std::uint64_t visible_voxels) {
  const double low = plain(range.low), high = plain(range.high);
  if (!tf.visible_within(range.low, range.high))
    return fmt::format(
        "the picture is empty: transfer function '{}' is opaque {}, but the volume's values run from {:g} to "
        "{:g}; hint: try --tf auto",
        tf.name, visible_range(tf), low, high);
  if (visible_voxels == 0)
    return fmt::format(
        "the picture is empty: transfer function '{}' is opaque {}, and no voxel has such a value though the "
        "volume's "
        "run from {:g} to {:g}; hint: ringsplat info shows the histogram, or try --tf auto",
        tf.name, visible_range(tf), low, high);
  return fmt::format(
      "the picture is empty: no visible voxel lies in it (values from {:g} to {:g}, transfer function '{}' "
      "opaque {}); hint: check "
      "--zoom or --matrix, or try --tf auto",
      low, high, tf.name, visible_range(tf));
}

}  // namespace ringsplat::app
