#pragma once
#include <string>
#include <vector>

#include "base/srgb.hpp"
#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {

/// A map of colours over 0..1, known by its name in matplotlib or ParaView.
struct ColourMap {
  std::string name;
  std::vector<TransferFunction::ColourPoint> points;  ///< from 0 to 1
};

/// Perceptual ones first.
std::vector<PresetName> colour_map_names();

/// Upper and lower case, blanks and hyphens are the same. Throws InputError listing the names for an unknown
/// one.
ColourMap colour_map(const std::string& name);

}  // namespace ringsplat
