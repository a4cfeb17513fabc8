#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {

/// A map of colours over 0..1, known by its name in matplotlib or ParaView.
struct ColourMap {
  std::string name;
  std::vector<TransferFunction::ColourPoint> points;  ///< from 0 to 1
};

struct ColourMapName {
  std::string name, description;
};
/// The display colour 0xrrggbb.
inline glm::dvec3 colour_of(std::uint32_t rgb) {
  return {double(rgb >> 16 & 255) / 255, double(rgb >> 8 & 255) / 255, double(rgb & 255) / 255};
}

/// Perceptual ones first.
const std::vector<ColourMapName>& colour_map_names();

/// Upper and lower case, blanks and hyphens are the same. Throws InputError listing the names for an unknown
/// one.
ColourMap colour_map(const std::string& name);

}  // namespace ringsplat
