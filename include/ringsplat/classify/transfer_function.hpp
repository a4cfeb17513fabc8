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
/// Colours are display (sRGB) values at the points, as in ParaView; between points linear light is
/// interpolated. Opacity is per voxel length. Not-a-number is transparent (its colour is kept for writing
/// back only).
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
  std::vector<OpacityPoint> opacities;  ///< ascending values, too
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

/// Reads ParaView's JSON colour map (an object, or a list of one): RGBPoints, Points, NanColor, Name. Opacity
/// pieces whose midpoint and sharpness are not 0.5 and 0 are sampled. Throws InputError naming file and
/// field. A map without opacity points gets a ramp from clear to opaque over its colours; then `*ramp`
/// becomes true.
TransferFunction read_transfer_function(const std::filesystem::path& file, bool* ramp = nullptr);
TransferFunction parse_transfer_function(const std::string& json, const std::string& where,
                                         bool* ramp = nullptr);
std::string to_paraview_json(const TransferFunction& tf);

/// Presets by name, each with a line of description: "mr-soft", "mr-surface", "mr-skin", "ct-bone",
/// "ct-skin", "ct-soft", "grey" ... Presets for MR and for float data span the range given; CT ones
/// are in Hounsfield units. "auto" is chosen by the values.
struct PresetName {
  std::string name, description;
};
std::vector<PresetName> preset_names();
/// `histogram` spans the volume's range. Throws InputError listing the names for an unknown one.
TransferFunction preset(const std::string& name, const Histogram& histogram);

}  // namespace ringsplat
