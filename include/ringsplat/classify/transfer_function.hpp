#pragma once
#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "ringsplat/volume/statistics.hpp"

namespace ringsplat {

/// Straight (not premultiplied) linear colour and opacity per unit length.
struct ClassifiedSample {
  float r, g, b, opacity;
};

/// Piecewise-linear colour and opacity over data values; constant beyond the first and last point.
///
/// Colours are given as display (sRGB) values, as ParaView's are, and turned into linear light at the
/// points; between points linear light is interpolated. Opacity is per voxel length.
/// Not-a-number is transparent (its colour is kept for writing back only).
struct TransferFunction {
  struct ColourPoint {
    double value;
    glm::dvec3 srgb;  ///< 0..1
    bool operator==(const ColourPoint&) const = default;
  };
  struct OpacityPoint {
    double value, opacity;  ///< 0..1
    bool operator==(const OpacityPoint&) const = default;
  };
  std::string name = "unnamed";
  std::vector<ColourPoint> colours;     ///< ascending values (equal values make a jump), at least two points
  std::vector<OpacityPoint> opacities;  ///< likewise
  glm::dvec3 nan_srgb{1.0, 0.0, 0.0};

  struct Sample {
    glm::dvec3 colour;  ///< straight, linear
    double opacity;     ///< per unit length
  };
  Sample evaluate(double value) const;
  /// True when some value in [low, high] has opacity above zero.
  bool visible_within(double low, double high) const;
  bool operator==(const TransferFunction&) const = default;
};

/// Throws InputError naming the field: fewer than two points, not ascending, not finite, outside 0..1.
void check(const TransferFunction& tf, const std::string& where);

/// ParaView's JSON colour map (a list of one object, or one object): RGBPoints, Points (with ParaView's
/// midpoint and sharpness kept only when they are the neutral 0.5 and 0; others are sampled), NanColor,
/// Name. Throws InputError naming file and field.
TransferFunction read_transfer_function(const std::filesystem::path& file);
TransferFunction parse_transfer_function(const std::string& json, const std::string& where);
std::string to_paraview_json(const TransferFunction& tf);

/// Presets by name, each with a line of description: "mr-soft", "mr-surface", "mr-skin", "ct-bone",
/// "ct-skin", "ct-soft", "grey" ... Presets for MR and for float data span the range given; CT ones
/// are in Hounsfield units. "auto" is made from the histogram.
struct PresetName {
  std::string name, description;
};
const std::vector<PresetName>& preset_names();
/// `histogram` spans the volume's range. Throws InputError that lists the names.
TransferFunction preset(const std::string& name, const Histogram& histogram);

}  // namespace ringsplat
