#pragma once
#include <optional>
#include <string>

#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat::app {

/// Values from `low` to `high` > low, both finite.
struct ValueWindow {
  double low, high;
};

/// Changes of the transfer function that --tf chooses.
struct ColourOptions {
  std::optional<ValueWindow> range;  ///< what it spans
  double opacity = 1;                ///< as dense so many times
  std::string colours;               ///< a colour map's name; empty: its own colours
  bool log = false;                  ///< on a logarithmic axis
  bool labels = false;               ///< a colour for each value instead
  /// Between voxels; without a value nearest for labels, else linear.
  std::optional<Interpolation> interpolation;
};

/// "LO:HI". Throws InputError that names `option`.
ValueWindow parse_window(const std::string& text, const std::string& option);
/// A number above 0. Throws InputError that names `option`.
double parse_density(const std::string& text, const std::string& option);

/// Names and descriptions, a line each.
std::string list_of_colour_maps();

}  // namespace ringsplat::app
