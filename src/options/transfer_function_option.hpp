#pragma once
#include <optional>
#include <string>

#include "classify/auto_preset.hpp"
#include "classify/colour_maps.hpp"
#include "options/options.hpp"
#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat::app {

/// What people are told of a transfer function.
struct MadeFunction {
  std::string said;  ///< what "auto" has chosen and why, in one line; empty when nothing was chosen
  bool labels = false;
};

/// The choice of --tf: a preset, fitted to the volume's values, or a file; changed as the colour options say.
class TransferFunctionChoice {
 public:
  /// Reads a file immediately. Throws InputError when `text` is neither a preset nor a readable transfer
  /// function, or when there is no such colour map.
  explicit TransferFunctionChoice(const std::string& text, const ColourOptions& colour = {});
  /// Sets what is shown: the function, and what the colour options say of it. Throws InputError when the
  /// values do not allow what is asked: no finite one, no positive one for --log, no whole numbers for
  /// --labels.
  MadeFunction make(const ValueStatistics& values, Shown& shown) const;

 private:
  AutoChoice base(const ValueStatistics& values) const;

  ColourOptions colour_;
  std::optional<ColourMap> map_;
  std::string preset_;
  std::optional<TransferFunction> from_file_;
  bool ramp_ = false;  ///< the file has no opacities
};

/// Names and descriptions, a line each.
std::string list_of_colour_maps();

/// Why sheets err with such a transfer function, and what to do: their tables have a thousand nodes for all
/// values; empty where these suffice.
std::string why_sheets_err(const TransferFunction& tf, const DataRange& range);

/// Why sheets give labels each other's colours; empty where there are not too many values for that.
std::string why_labels_merge(const DataRange& range);

}  // namespace ringsplat::app
